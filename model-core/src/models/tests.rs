//! Helpers of the model tests, and tests common to all models.

use super::ActuatorModel;
use super::black_box_1::{BlackBox1, BlackBox1Parameters};
use super::black_box_2::{BlackBox2, BlackBox2Parameters};
use super::grey_box::{GreyBox, GreyBoxParameters};
use crate::limits::hard_stop;
use proptest::prelude::*;
use std::boxed::Box;
use std::vec::Vec;

/// Angle after `ticks` with the command held, deg.
pub(super) fn angle_after(model: &mut impl ActuatorModel, command_deg: f64, ticks: u32) -> f64 {
    for _ in 0..ticks {
        model.advance_tick(command_deg);
    }
    model.output(command_deg).angle_deg
}

/// All models with these limits.
fn limited(up_deg_s: f64, down_deg_s: f64, limit_deg: f64) -> Vec<Box<dyn ActuatorModel>> {
    let mut models: Vec<Box<dyn ActuatorModel>> = std::vec![
        Box::new(
            BlackBox1::try_new(BlackBox1Parameters {
                rate_limit_up_deg_s: up_deg_s,
                rate_limit_down_deg_s: down_deg_s,
                position_limit_deg: limit_deg,
                ..Default::default()
            })
            .unwrap(),
        ),
        Box::new(
            GreyBox::try_new(GreyBoxParameters {
                rate_limit_up_deg_s: up_deg_s,
                rate_limit_down_deg_s: down_deg_s,
                position_limit_deg: limit_deg,
                ..Default::default()
            })
            .unwrap(),
        ),
    ];
    for rate_limit_form in [0.0, 1.0, 2.0] {
        let parameters = BlackBox2Parameters {
            rate_limit_up_deg_s: up_deg_s,
            rate_limit_down_deg_s: down_deg_s,
            position_limit_deg: limit_deg,
            rate_limit_form,
            ..Default::default()
        };
        models.push(Box::new(BlackBox2::try_new(parameters).unwrap()));
    }
    models
}

/// Any number, sometimes NaN or infinite.
fn any_command() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => -400.0..400.0,
        1 => any::<f64>(),
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
        1 => Just(f64::NEG_INFINITY),
        1 => Just(f64::MAX),
    ]
}

proptest! {
    #[test]
    fn every_command_leaves_a_model_within_its_limits_and_finite(
        (up, down, stop) in (0.0..500.0, 0.0..500.0, 0.0..180.0),
        commands in proptest::collection::vec((any_command(), 1_u32..400), 1..12),
    ) {
        for model in &mut limited(up, down, stop) {
            for (command_deg, ticks) in &commands {
                for _ in 0..*ticks {
                    model.advance_tick(*command_deg);
                    let seen = model.output(0.0);
                    prop_assert!((-stop..=stop).contains(&seen.angle_deg), "{seen:?}");
                    prop_assert!((-down..=up).contains(&seen.rate_deg_s), "{seen:?}");
                    prop_assert!((-100.0..=100.0).contains(&seen.duty_pct), "{seen:?}");
                }
            }
        }
    }

    #[test]
    fn without_limits_any_command_leaves_a_finite_angle(
        commands in proptest::collection::vec(any_command(), 1..200),
    ) {
        let infinite = f64::INFINITY;
        for model in &mut limited(infinite, infinite, infinite) {
            for command_deg in &commands {
                model.advance_tick(*command_deg);
                prop_assert!(model.output(0.0).angle_deg.is_finite());
            }
        }
    }
}

#[test]
fn a_nan_command_leaves_the_state_unchanged() {
    for model in &mut limited(240.0, 350.0, 180.0) {
        for _ in 0..1000 {
            model.advance_tick(30.0);
        }
        let before = model.output(30.0);
        model.advance_tick(f64::NAN);
        assert_eq!(model.output(30.0), before);
        assert_eq!(model.output(f64::NAN).angle_deg, before.angle_deg);
    }
}

#[test]
fn a_hard_stop_clears_an_outward_rate_and_keeps_an_inward_one() {
    assert_eq!(hard_stop(181.0, 5.0, 180.0), (180.0, 0.0));
    assert_eq!(hard_stop(181.0, -5.0, 180.0), (180.0, -5.0));
    assert_eq!(hard_stop(-181.0, -5.0, 180.0), (-180.0, 0.0));
    assert_eq!(hard_stop(180.0, 5.0, 180.0), (180.0, 5.0));
}
