//! A motor with friction and a load: from logged duty, or within the position loop of a servo.
//!
//! ```text
//! J w' = k/R (v - k w) + external - friction        angle' = w
//! v = supply * duty                   logged, or sat(Kd (command - angle), +-umax)
//! external = load - m g l sin(angle - vertical)     J = N^2 Jm + m l^2
//! ```
//!
//! at the output shaft, `k` being `N` times the motor's torque constant. Friction is that of
//! [`friction`](super::friction): what would stop the shaft, limited to its budget (Duclusaud,
//! Passault et al., arXiv 2410.08650). Names and units are those of the bench of the simulator; with
//! a gear ratio of 1 everything is as the output shows it.

mod shaft;

use std::sync::Arc;

use model_core::parameter::{Parameter, Parameters};
use model_core::plant::drivetrain::electrical::ElectricalParameters;
use model_core::plant::drivetrain::gear_train::GearTrainParameters;
use model_core::plant::drivetrain::load::LoadParameters;

use super::Dynamics;
use super::friction::{COUNT, coefficients, neutral, usual_bounds};
use super::tables::{InitialState, delay, row};
use crate::experiment::Experiment;
use crate::flow::{Watch, drive_steps};
use crate::model::{Description, Model};
use crate::recording::{Recording, RecordingError};
use crate::scalar::Scalar;
use crate::start;
use shaft::Shaft;

model_core::parameters! {
    /// What the bench of the simulator has not, or not as one number.
    pub struct RigParameters {
        /// Duty per error of the angle, of a servo that is a position loop.
        duty_per_error_pct_deg ["Kd"]: 10.0, "%/deg", 1e-4, 1e4, "full duty at 10 deg";
        /// By what its firmware multiplies that: the gain that is set in a smart servo.
        firmware_gain ["kp"]: 1.0, "1", 1e-6, 1e6, "none";
        /// Greatest magnitude of the duty.
        duty_limit_pct ["umax"]: 100.0, "%", 1.0, 100.0, "the whole bridge";
        /// Measured angle at which the pendulum hangs.
        vertical_deg [""]: 0.0, "deg", -180.0, 180.0, "the arm hangs at zero";
        /// By how much positive voltage drives more than its share, and negative less.
        drive_asymmetry [""]: 0.0, "1", -0.9, 0.9, "none";
    }
}

/// What sets the voltage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drive {
    /// The logged duty.
    Duty,
    /// A position loop inside of the servo, from the command.
    Position,
}

/// Motor, friction, pendulum.
#[derive(Debug, Clone)]
pub struct Motor {
    drive: Drive,
    friction: usize,
    parameters: Vec<Parameter>,
    /// Whether each is fixed unless somebody frees it.
    fixed: Vec<bool>,
}

/// Places of the parameters; the friction's coefficients and the initial state follow.
const TORQUE_CONSTANT: usize = 0;
const RESISTANCE: usize = 1;
const INERTIA: usize = 2;
const DELAY: usize = 3;
const DUTY_PER_ERROR: usize = 4;
const VERTICAL: usize = 5;
const DUTY_LIMIT: usize = 6;
const SUPPLY: usize = 7;
const GEAR_RATIO: usize = 8;
const MASS: usize = 9;
const LENGTH: usize = 10;
const LOAD: usize = 11;
const BACKLASH: usize = 12;
const ASYMMETRY: usize = 13;
const STOP: usize = 14;
const FIRMWARE: usize = 15;
const FRICTION: usize = 16;
const ANGLE: usize = FRICTION + COUNT;
const RATE: usize = ANGLE + 1;

/// A parameter of the bench as seen at the output shaft: another default, a wider range.
fn seen<P: Parameters>(name: &str, default: f64, min: f64, max: f64) -> Parameter {
    Parameter {
        default,
        min,
        max,
        ..row::<P>(name)
    }
}

impl Motor {
    /// The motor with friction model `friction`, 1 to 6.
    pub fn new(drive: Drive, friction: usize) -> Self {
        let mut parameters = vec![
            seen::<ElectricalParameters>("torque_constant_nm_a", 1.6, 1e-5, 100.0),
            seen::<ElectricalParameters>("winding_resistance_ohm", 2.0, 1e-2, 1e3),
            seen::<GearTrainParameters>("motor_inertia_kg_m2", 5e-3, 1e-10, 10.0),
            delay(),
            row::<RigParameters>("duty_per_error_pct_deg"),
            row::<RigParameters>("vertical_deg"),
            row::<RigParameters>("duty_limit_pct"),
            seen::<ElectricalParameters>("supply_v", 12.0, 0.1, 1e3),
            seen::<GearTrainParameters>("gear_ratio", 1.0, 1.0, 2000.0),
            row::<LoadParameters>("pendulum_mass_kg"),
            row::<LoadParameters>("pendulum_length_m"),
            row::<LoadParameters>("load_torque_nm"),
            seen::<GearTrainParameters>("backlash_deg", 0.0, 0.0, 20.0),
            row::<RigParameters>("drive_asymmetry"),
            seen::<GearTrainParameters>("hard_stop_deg", f64::INFINITY, 0.0, f64::INFINITY),
            row::<RigParameters>("firmware_gain"),
        ];
        let mut fixed: Vec<bool> = (0..parameters.len())
            .map(|i| match i {
                // What is seen is k/R, and k^2/R with the viscous friction: R is to be measured.
                TORQUE_CONSTANT | INERTIA | DELAY => false,
                DUTY_PER_ERROR => drive == Drive::Duty,
                _ => true,
            })
            .collect();
        for (row, is_there) in coefficients(friction) {
            parameters.push(row);
            fixed.push(!is_there);
        }
        parameters.push(row::<InitialState>("initial_angle_deg"));
        parameters.push(row::<InitialState>("initial_rate_deg_s"));
        fixed.extend([false, true]);
        Self {
            drive,
            friction,
            parameters,
            fixed,
        }
    }
}

impl Description for Motor {
    fn name(&self) -> &'static str {
        const MOTORS: [&str; 6] = [
            "motor-m1", "motor-m2", "motor-m3", "motor-m4", "motor-m5", "motor-m6",
        ];
        const SERVOS: [&str; 6] = [
            "servo-m1", "servo-m2", "servo-m3", "servo-m4", "servo-m5", "servo-m6",
        ];
        match self.drive {
            Drive::Duty => MOTORS[self.friction - 1],
            Drive::Position => SERVOS[self.friction - 1],
        }
    }

    fn summary(&self) -> &'static str {
        match self.drive {
            Drive::Duty => "motor from logged duty, with friction M1 to M6 and a pendulum",
            Drive::Position => "the same motor within a position loop, from the command",
        }
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn is_of_the_run(&self, parameter: usize) -> bool {
        parameter >= ANGLE
    }

    fn is_fixed_by_default(&self, parameter: usize) -> bool {
        self.fixed[parameter]
    }

    fn usual_bounds(&self, parameter: usize) -> (f64, f64) {
        let Parameter { min, max, .. } = self.parameters[parameter];
        let coefficient = parameter.checked_sub(FRICTION);
        coefficient.and_then(usual_bounds).unwrap_or((min, max))
    }

    fn accepts(&self, recording: &Recording) -> Result<(), RecordingError> {
        match (self.drive, &recording.duty_pct) {
            (Drive::Duty, None) => Err(RecordingError::Missing("duty_pct")),
            _ => Ok(()),
        }
    }

    fn start(&self, experiments: &[Experiment]) -> Vec<f64> {
        let look = start::look(experiments);
        let mut values: Vec<f64> = self.parameters.iter().map(|p| p.default).collect();
        values[DELAY] = match self.drive {
            Drive::Duty => 0.005,
            Drive::Position => 0.2 * look.lag_s,
        };
        // The fastest that was seen is at most the no-load rate.
        let fastest_rad_s = look.rate_up_deg_s.max(look.rate_down_deg_s).to_radians();
        let supply_v = experiments.first().and_then(|e| e.supply_v);
        let supply_v = supply_v.unwrap_or(values[SUPPLY]);
        values[TORQUE_CONSTANT] = (0.6 * supply_v / fastest_rad_s.max(0.1)).clamp(0.05, 20.0);
        let gains = experiments.iter();
        let gains = gains.filter_map(|e| e.recording.constants.get("firmware_gain"));
        let greatest = gains.fold(0.0_f64, |greatest, gain| greatest.max(*gain));
        if greatest > 0.0 {
            values[DUTY_PER_ERROR] /= greatest;
        }
        values[ANGLE] = look.initial_angle_deg;
        values
    }

    fn special_cases(&self) -> Vec<Arc<dyn Model>> {
        let cases: &[usize] = match self.friction {
            1 => &[],
            2 | 3 => &[1],
            4 => &[2, 3],
            5 => &[4],
            _ => &[5],
        };
        let case = |friction: &usize| Arc::new(Self::new(self.drive, *friction)) as _;
        cases.iter().map(case).collect()
    }

    fn contains_its_cases(&self) -> bool {
        true
    }

    fn lifted(&self, parameter: usize, case: &dyn Model, values: &[f64]) -> Option<f64> {
        // All motors have the same parameters in the same places.
        let is_new = case.is_fixed_by_default(parameter) && !self.fixed[parameter];
        match parameter.checked_sub(FRICTION) {
            Some(coefficient) if is_new => Some(neutral(coefficient, &values[FRICTION..])),
            _ => Some(values[parameter]),
        }
    }

    fn is_rough(&self) -> bool {
        true
    }
}

impl Dynamics for Motor {
    fn run<S: Scalar>(&self, run: &Experiment, values: &[S], seen: &mut impl Watch<S>) {
        let is_known = run.recording.constants.contains_key("supply_v");
        let supply = match run.supply_v {
            Some(mean_v) if !is_known => S::constant(mean_v),
            _ => values[SUPPLY],
        };
        let mut shaft = Shaft::new(self.friction, values, supply, self.drive == Drive::Position);
        if run.is_preview {
            shaft = shaft.in_longer_steps();
        }
        let input = match self.drive {
            Drive::Duty => &run.drive,
            Drive::Position => &run.command,
        };
        drive_steps(&mut shaft, run, input, values[DELAY], seen);
    }
}
