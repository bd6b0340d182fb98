//! The grey box: motor, PI rate loop and P position loop in continuous time, as
//! [`model_core::models::grey_box`] steps it, whose equations and names these are.

mod modes;

use model_core::models::grey_box::GreyBoxParameters;
use model_core::parameter::Parameter;

use super::Dynamics;
use super::tables::{InitialState, bounded, delay, rate_limit, row};
use crate::experiment::Experiment;
use crate::flow::{Watch, drive};
use crate::model::Description;
use crate::scalar::Scalar;
use crate::start;
use modes::Servo;

/// Motor, rate loop and position loop, behind a delay.
///
/// The controller is known to who built it, so that only motor and delay are looked for unless
/// somebody frees more: from command and angle alone only products of their gains are seen where
/// nothing saturates.
#[derive(Debug, Clone)]
pub struct GreyBox {
    parameters: Vec<Parameter>,
}

/// Places of the parameters.
const GAIN_UP: usize = 0;
const GAIN_DOWN: usize = 1;
const TIME_CONSTANT: usize = 2;
const DELAY: usize = 3;
const PROPORTIONAL: usize = 4;
const INTEGRAL: usize = 5;
const POSITION: usize = 6;
const ANTI_WINDUP: usize = 7;
const RATE_ANTI_WINDUP: usize = 8;
const DUTY_LIMIT: usize = 9;
const UP: usize = 10;
const DOWN: usize = 11;
const STOP: usize = 12;
const ANGLE: usize = 13;
const RATE: usize = 14;

impl Default for GreyBox {
    fn default() -> Self {
        type Table = GreyBoxParameters;
        Self {
            parameters: vec![
                bounded::<Table>("motor_gain_up", 1e-3, 1e3),
                bounded::<Table>("motor_gain_down", 1e-3, 1e3),
                bounded::<Table>("motor_time_constant_s", 1e-3, 100.0),
                delay(),
                bounded::<Table>("proportional_gain", 1e-4, 1e3),
                row::<Table>("integral_gain"),
                bounded::<Table>("position_gain", 1e-2, 5e3),
                row::<Table>("anti_windup_gain"),
                row::<Table>("rate_anti_windup_gain"),
                bounded::<Table>("duty_limit_pct", 1e-3, f64::INFINITY),
                rate_limit::<Table>("rate_limit_up_deg_s"),
                rate_limit::<Table>("rate_limit_down_deg_s"),
                row::<Table>("position_limit_deg"),
                row::<InitialState>("initial_angle_deg"),
                row::<InitialState>("initial_rate_deg_s"),
            ],
        }
    }
}

impl Description for GreyBox {
    fn name(&self) -> &'static str {
        "grey-box"
    }

    fn summary(&self) -> &'static str {
        "motor, PI rate loop and P position loop with delay and limits"
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn is_of_the_run(&self, parameter: usize) -> bool {
        parameter >= ANGLE
    }

    fn is_fixed_by_default(&self, parameter: usize) -> bool {
        !matches!(
            parameter,
            GAIN_UP | GAIN_DOWN | TIME_CONSTANT | DELAY | ANGLE
        )
    }

    fn is_limit(&self, parameter: usize) -> bool {
        matches!(parameter, UP | DOWN)
    }

    fn start(&self, experiments: &[Experiment]) -> Vec<f64> {
        let look = start::look(experiments);
        let mut values: Vec<f64> = self.parameters.iter().map(|p| p.default).collect();
        // Where the whole duty is reached, the rate is the gain times 100 %.
        values[GAIN_UP] = look.rate_up_deg_s / 100.0;
        values[GAIN_DOWN] = look.rate_down_deg_s / 100.0;
        values[DELAY] = look.second_order_delay_s;
        values[UP] = f64::INFINITY;
        values[DOWN] = f64::INFINITY;
        values[STOP] = f64::INFINITY;
        values[ANGLE] = look.initial_angle_deg;
        values[RATE] = look.initial_rate_deg_s;
        values
    }
}

impl Dynamics for GreyBox {
    #[inline(always)]
    fn run<S: Scalar>(&self, run: &Experiment, values: &[S], seen: &mut impl Watch<S>) {
        let servo = Servo {
            gain_up: values[GAIN_UP],
            gain_down: values[GAIN_DOWN],
            time_constant: values[TIME_CONSTANT],
            proportional: values[PROPORTIONAL],
            integral: values[INTEGRAL],
            position: values[POSITION],
            anti_windup: values[ANTI_WINDUP],
            rate_anti_windup: values[RATE_ANTI_WINDUP],
            duty_limit: values[DUTY_LIMIT],
            up: values[UP],
            down: values[DOWN],
            stop: values[STOP],
        };
        let initial = [values[ANGLE], values[RATE], S::constant(0.0)];
        drive(&servo, run, initial, values[DELAY], seen);
    }
}
