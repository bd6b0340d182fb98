//! The float models against the referee, on all its inputs.
//!
//! It covers the presets, as each model is created from one. It does not cover the hard stops,
//! which no input of the referee reaches.

use model_core::models::ActuatorModel;
use model_core::models::black_box_1::BlackBox1;
use model_core::models::black_box_2::BlackBox2;
use model_core::models::delay::DelayLine;
use model_core::models::grey_box::GreyBox;
use model_core::parameter::Parameters;
use model_core::presets::preset;
use system_tests::{INPUTS, command, golden, same_in_print};

/// The transport delay of the paper, 17.5 ms.
const DELAY_TICKS: u64 = 350;

/// The defaults with the values of a preset.
fn parameters<P: Parameters>(name: &str) -> P {
    let mut parameters = P::default();
    for (parameter, value) in preset(name).expect("a preset").values {
        parameters.set(parameter, *value).expect("a value in range");
    }
    parameters
}

/// Runs a model on every input and compares each recorded row.
///
/// The required agreement is 1e-3 deg and 0.2 deg/s. As the models compute with the referee's
/// arithmetic in the same order, the printed rows must be equal.
fn agrees_with_the_referee(referee: &str, start: &impl Fn() -> Box<dyn ActuatorModel>) {
    for input in INPUTS {
        let mut model = start();
        let mut delay = DelayLine::<[f64; 350]>::try_new(DELAY_TICKS).expect("as long as the line");
        let mut tick = 0;
        for row in golden(referee, input) {
            while tick < row.tick {
                model.advance_tick(delay.shift(command(input, tick)));
                tick += 1;
            }
            // The delay line advances with the next step: its present output is read from a copy.
            let delayed_deg = delay.clone().shift(command(input, tick));
            let seen = model.output(delayed_deg);
            for (value, printed) in [
                (delayed_deg, row.command_delayed_deg),
                (seen.angle_deg, row.angle_deg),
                (seen.rate_deg_s, row.rate_deg_s),
                (seen.duty_pct, row.duty_pct),
            ] {
                assert!(
                    same_in_print(value, printed),
                    "{referee} on {input}: {value} for {printed} in {row:?}"
                );
            }
        }
    }
}

#[test]
fn black_box_1_is_the_referees_bb1() {
    agrees_with_the_referee("bb1", &|| {
        Box::new(BlackBox1::try_new(parameters("paper")).expect("in range"))
    });
}

#[test]
fn black_box_2_is_the_referees_bb2() {
    agrees_with_the_referee("bb2", &|| {
        Box::new(BlackBox2::try_new(parameters("paper")).expect("in range"))
    });
}

#[test]
fn the_grey_box_in_each_reading_is_the_referees() {
    for (referee, name) in [
        ("grey", "consistent"),
        ("grey-asym", "asymmetric"),
        ("grey-paper", "as-printed"),
        ("grey-strict", "as-printed-strict"),
    ] {
        agrees_with_the_referee(referee, &|| {
            Box::new(GreyBox::try_new(parameters(name)).expect("in range"))
        });
    }
}
