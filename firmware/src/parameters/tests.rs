use proptest::prelude::*;

use super::*;

fn number(name: &str) -> u8 {
    BoardParameters::number_of(name).expect(name)
}

#[test]
fn the_defaults_are_possible_and_lie_in_their_ranges() {
    assert_eq!(BoardParameters::DEFAULT.check(), Ok(()));
}

#[test]
fn every_parameter_has_a_name_of_its_own_and_a_value() {
    for n in 0..BoardParameters::COUNT {
        let name = BoardParameters::meaning(n).unwrap().name();
        assert_eq!(number(name), n, "{name}");
        assert!(BoardParameters::DEFAULT.get(n).is_some(), "{name}");
    }
    assert!(BoardParameters::meaning(BoardParameters::COUNT).is_none());
    assert!(
        BoardParameters::DEFAULT
            .get(BoardParameters::COUNT)
            .is_none()
    );
}

#[test]
fn what_is_at_odds_is_named() {
    type Change = fn(&mut BoardParameters);
    let odds: [(&str, Change); 5] = [
        ("pulse_centre_us", |p| p.servo.pulse_centre_us = 2000),
        ("bit_rate_kbit_s", |p| p.bus.bit_rate_kbit_s = 800),
        ("under_voltage_mv", |p| p.supply.over_voltage_mv = 4000),
        ("continuous_ma", |p| p.current.over_current_ma = 400),
        ("node_id", |p| p.bus.node_id = 128),
    ];
    for (name, make) in odds {
        let mut parameters = BoardParameters::DEFAULT;
        make(&mut parameters);
        assert_eq!(parameters.check(), Err(number(name)), "{name}");
        assert_eq!(
            BoardParameters::from_words(&parameters.words()),
            None,
            "{name}"
        );
    }
}

proptest! {
    #[test]
    fn what_is_set_is_read_and_survives_the_way_through_words(
        changes in proptest::collection::vec((0..BoardParameters::COUNT, any::<i32>()), 0..50)
    ) {
        let mut parameters = BoardParameters::DEFAULT;
        for (n, seed) in changes {
            let value = match BoardParameters::meaning(n).unwrap() {
                Meaning::Real(_) => Value::Real(seed as f32 / 1e6),
                Meaning::Integer(row) => {
                    let span = i64::from(row.range.max) - i64::from(row.range.min) + 3;
                    let offset = i64::from(seed).rem_euclid(span) - 1;
                    Value::Integer((i64::from(row.range.min) + offset) as i32)
                }
            };
            let before = parameters;
            if parameters.set(n, value) {
                let is_coarse = n == number("encoder_zero_deg");
                let read = parameters.get(n).unwrap();
                prop_assert!(is_coarse || read == value || n == number("duty_slew_pct_s"), "{n}: {read:?} {value:?}");
            } else {
                prop_assert_eq!(parameters, before);
            }
        }
        let is_possible = parameters.check().is_ok();
        let read = BoardParameters::from_words(&parameters.words());
        prop_assert_eq!(read, is_possible.then_some(parameters));
    }

    #[test]
    fn no_words_make_impossible_parameters(index in 0..WORDS, word: u32) {
        let mut words = BoardParameters::DEFAULT.words();
        words[index] = word;
        if let Some(parameters) = BoardParameters::from_words(&words) {
            prop_assert_eq!(parameters.check(), Ok(()));
        }
    }
}
