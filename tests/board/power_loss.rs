//! The supply is cut in every operation of a save: afterwards the board has the old or the new
//! parameters.

use board_tests::cuts::{Cut, Cuts};
use board_tests::frames::faults;
use board_tests::program::run_script;
use firmware::faults::Fault;
use firmware::parameters::BoardParameters;
use virtual_board::flash::Operation;
use virtual_board::plant::Bridge;
use virtual_board::run::{Finished, Options};

/// The over-current limit: the default, and the values that are saved one after the other, mA.
const LIMITS_MA: [u32; 3] = [
    BoardParameters::DEFAULT.current.over_current_ma as u32,
    1234,
    1235,
];

/// Upper limit of the duration of all saves, ms.
const LIMIT_MS: u64 = 200_000;

/// Number of words at both ends of a page that are all cut.
const EVERY_WORD: usize = 16;

/// Distance of the cuts between them.
const DISTANCE: usize = 4;

/// Cuts in the middle of word programming and at several stages of erases. A cut takes two starts
/// of the board, so only some words in the middle of a page, which are all equivalent, are cut; the
/// tests of `firmware::store` cut every word. With the environment variable `EXHAUSTIVE` every word
/// is cut here too.
fn everywhere(operations: &[Operation]) -> Vec<Cut> {
    let exhaustive = std::env::var_os("EXHAUSTIVE").is_some();
    let end = operations.len().saturating_sub(EVERY_WORD);
    let mut cuts = Vec::new();
    for (number, operation) in operations.iter().enumerate() {
        let is_cut = exhaustive || number < EVERY_WORD || number >= end || number % DISTANCE == 0;
        let stages: &[u64] = match operation {
            Operation::Erase { .. } => &[0, 10, 130, 300, 500, 700, 900, 999],
            Operation::Program { .. } if is_cut => &[500],
            Operation::Program { .. } => &[],
        };
        cuts.extend(stages.iter().map(|&permille| Cut {
            operation: number as u64,
            permille,
        }));
    }
    cuts
}

/// The last word of a page is its CRC.
fn in_the_crc(operations: &[Operation]) -> Vec<Cut> {
    vec![Cut {
        operation: operations.len() as u64 - 1,
        // Half of the bits have changed: neither none nor all of them.
        permille: 200,
    }]
}

fn run_cuts(values: &[u32], choose: fn(&[Operation]) -> Vec<Cut>) -> Finished<Cuts> {
    let script = Cuts::new(values, choose);
    let finished = run_script(Options::for_ms(LIMIT_MS), script);
    assert!(finished.script.is_done(), "{} ns", finished.end_ns);
    finished
}

/// Counts how often the board had each of two values after a cut, and asserts that it had no other.
fn count(finished: &Finished<Cuts>, values: [u32; 2]) -> [usize; 2] {
    let held = &finished.script.held;
    for (cut, value) in held {
        assert!(values.contains(value), "{cut:?}: {value}");
    }
    let counts = values.map(|value| held.iter().filter(|(_, held)| *held == value).count());
    println!(
        "{} cuts in {} ms: the old set {} times, the new {} times",
        held.len(),
        finished.end_ns / 1_000_000,
        counts[0],
        counts[1]
    );
    counts
}

#[test]
fn after_a_loss_of_supply_in_any_word_of_the_first_save_the_parameters_are_valid() {
    let finished = run_cuts(&[LIMITS_MA[1]], everywhere);
    let [old, _] = count(&finished, [LIMITS_MA[0], LIMITS_MA[1]]);
    assert!(old > 20, "{old}");
}

#[test]
fn after_a_loss_of_supply_in_an_erase_or_a_word_after_it_the_parameters_are_valid() {
    let finished = run_cuts(&LIMITS_MA[1..], everywhere);
    let erases = |(cut, _): &&(Cut, u32)| cut.operation == 0;
    let erases = finished.script.held.iter().filter(erases).count();
    assert_eq!(erases, 8, "a page that is not blank is erased");
    let [old, _] = count(&finished, [LIMITS_MA[1], LIMITS_MA[2]]);
    assert!(old > 8, "{old}");
}

/// A half-written CRC cannot be distinguished from a corrupt page.
#[test]
fn a_first_save_that_was_cut_in_its_crc_is_reported_as_corrupt_parameters_and_the_board_stays_off()
{
    let finished = run_cuts(&[LIMITS_MA[1]], in_the_crc);
    let reset_ns = finished
        .resets
        .last()
        .expect("the supply received back")
        .at
        .0;
    let faults = faults(&finished).into_iter();
    let mut after = faults.filter(|(at_ns, _)| *at_ns > reset_ns);
    let (_, number) = after.next_back().expect("the board reports a fault");
    assert_eq!(u16::from(number), Fault::ParametersCorrupt.number());
    let rows = finished.trace.rows.iter();
    assert!(rows.clone().any(|row| row.at_ns > reset_ns));
    for row in rows.filter(|row| row.at_ns > reset_ns) {
        let is_driven = matches!(row.bridge, Bridge::Driven { .. });
        assert!(!is_driven, "{} ns", row.at_ns);
    }
}
