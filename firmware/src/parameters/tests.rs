use proptest::prelude::*;

use super::*;

extern crate std;
use std::vec::Vec;

/// Smallest and largest integer of a range, found by bisection from a value inside it.
pub(crate) fn ends_of_range(inside: i32, is_inside: impl Fn(i32) -> bool) -> (i32, i32) {
    let end = |step: i64| {
        let mut end = i64::from(inside);
        let mut distance = 1_i64 << 32;
        while distance > 0 {
            let value = end + step * distance;
            if i32::try_from(value).is_ok_and(&is_inside) {
                end = value;
            } else {
                distance /= 2;
            }
        }
        end as i32
    };
    (end(-1), end(1))
}

fn words(parameters: &BoardParameters) -> Vec<u32> {
    let mut words = std::vec![0; CONTROL + Parameter::ALL.len()];
    parameters.write_words(&mut words.iter_mut());
    words
}

fn read(words: &[u32]) -> Option<BoardParameters> {
    BoardParameters::read_words(&mut words.iter().copied())
}

#[test]
fn the_defaults_are_valid() {
    assert_eq!(BoardParameters::DEFAULT.check(), Ok(()));
    assert_eq!(ObjectValues::DEFAULT.check(), Ok(()));
}

#[test]
fn names_are_unique() {
    let mut names: Vec<_> = Parameter::FIELDS
        .iter()
        .chain(ObjectValue::FIELDS)
        .collect();
    names.sort();
    let count = names.len();
    names.dedup();
    assert_eq!(names.len(), count);
    assert_eq!(Parameter::FIELDS.len(), Parameter::ALL.len());
    let at = Parameter::OverCurrentMa as usize;
    assert_eq!(Parameter::FIELDS[at], ("over_current_ma", "i32"));
    assert_eq!(Parameter::ALL[at], Parameter::OverCurrentMa);
}

#[test]
fn the_first_invalid_parameter_is_named() {
    type Change = fn(&mut BoardParameters);
    let cases: [(Parameter, Change); 6] = [
        (Parameter::PulseCentreUs, |p| p.servo.pulse_centre_us = 2000),
        (Parameter::PulseMinUs, |p| p.servo.pulse_min_us = 1500),
        (Parameter::BitRateKbitS, |p| p.bus.bit_rate_kbit_s = 800),
        (Parameter::UnderVoltageMv, |p| {
            p.supply.over_voltage_mv = 4000
        }),
        (Parameter::RatedMa, |p| p.current.over_current_ma = 400),
        (Parameter::NodeId, |p| p.bus.node_id = 128),
    ];
    for (parameter, change) in cases {
        let mut parameters = BoardParameters::DEFAULT;
        change(&mut parameters);
        assert_eq!(parameters.check(), Err(parameter));
        assert_eq!(read(&words(&parameters)), None, "{parameter:?}");
    }
}

#[test]
fn values_of_objects_are_checked_too() {
    let mut values = ObjectValues::DEFAULT;
    values.profile.min_position_mdeg = 60_001;
    assert_eq!(values.check(), Err(ObjectValue::MinPositionMdeg));
    values = ObjectValues::DEFAULT;
    values.model.gear_ratio = f32::NAN;
    assert_eq!(values.check(), Err(ObjectValue::GearRatio));
    values = ObjectValues::DEFAULT;
    values.profile.interpolation_index = -7;
    assert_eq!(values.check(), Err(ObjectValue::InterpolationIndex));
    let mut words = [0; ObjectValue::ALL.len()];
    values.write_words(&mut words.iter_mut());
    assert_eq!(ObjectValues::read_words(&mut words.into_iter()), None);
}

proptest! {
    #[test]
    fn valid_parameters_survive_the_round_trip_through_words(
        changes in proptest::collection::vec((0..CONTROL + Parameter::ALL.len(), any::<i32>(), -3..4), 0..50)
    ) {
        let mut parameters = BoardParameters::DEFAULT;
        for (number, seed, step) in changes {
            let before = parameters;
            match number.checked_sub(CONTROL) {
                None => {
                    let value = seed as f32 / 1e6;
                    if parameters.control.set(number, value) {
                        let read = parameters.control.get(number).unwrap();
                        let is_coarse = number == ControlParameters::row("encoder_zero_deg")
                            || number == ControlParameters::row("duty_slew_pct_s");
                        prop_assert!(is_coarse || read == value, "{number}: {read} {value}");
                    } else {
                        prop_assert_eq!(parameters, before);
                    }
                }
                Some(at) => {
                    let parameter = Parameter::ALL[at];
                    let near = (parameters.word(parameter) as i32).wrapping_add(step);
                    let value = if step == 0 { seed } else { near };
                    parameters.set_word(parameter, value as u32);
                    prop_assert_eq!(parameters.word(parameter), value as u32);
                    if !parameters.is_in_range(parameter) {
                        parameters = before;
                    }
                }
            }
        }
        let is_valid = parameters.check().is_ok();
        prop_assert_eq!(read(&words(&parameters)), is_valid.then_some(parameters));
    }

    #[test]
    fn no_words_make_invalid_parameters(index in 0..CONTROL + Parameter::ALL.len(), word: u32) {
        let mut words = words(&BoardParameters::DEFAULT);
        words[index] = word;
        if let Some(parameters) = read(&words) {
            prop_assert_eq!(parameters.check(), Ok(()));
        }
    }
}
