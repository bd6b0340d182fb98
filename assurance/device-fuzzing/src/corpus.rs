//! The inputs that a fuzzer has found, in `corpus.txt`: one in each line, in hexadecimal digits.

/// The file, as it was when this crate was built.
const CORPUS: &str = include_str!("../corpus.txt");

/// All inputs.
///
/// # Panics
/// If a line is not hexadecimal.
pub fn all() -> impl Iterator<Item = Vec<u8>> {
    CORPUS.lines().map(|line| {
        let (pairs, rest) = line.as_bytes().as_chunks::<2>();
        assert!(rest.is_empty(), "{line}: whole bytes");
        let digit = |digit: u8| char::from(digit).to_digit(16).expect("a digit") as u8;
        pairs
            .iter()
            .map(|[a, b]| digit(*a) << 4 | digit(*b))
            .collect()
    })
}

/// The line of an input.
pub fn line(input: &[u8]) -> String {
    input.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use firmware::application::BoardState;
    use proptest::prelude::*;

    use crate::run;

    #[test]
    fn what_must_hold_holds_for_every_input_that_was_found() {
        let (mut driven, mut states) = (0, BTreeSet::new());
        for input in super::all() {
            assert_eq!(super::line(&input).len(), 2 * input.len());
            let summary = run(&input);
            driven += u32::from(summary.driven > 0);
            states.extend(summary.states);
        }
        assert!(driven > 10, "{driven}");
        // Every state of the board, from Initialising to Fault; a stall of half a second is longer
        // than these inputs.
        let all = BoardState::Initialising as u8..=BoardState::Fault as u8;
        assert!(
            all.into_iter().all(|state| states.contains(&state)),
            "{states:?}"
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1_000))]
        #[test]
        fn what_must_hold_holds_after_these_inputs_and_any_bytes(
            first in prop::sample::select(super::all().collect::<Vec<_>>()),
            more in prop::collection::vec(any::<u8>(), 0..600),
        ) {
            run(&[first, more].concat());
        }
    }
}
