//! A motor with friction and a load: from logged duty, or within the position loop of a servo.
//!
//! ```text
//! J w' = k/R (v - k w) + external - friction        angle' = w
//! v = supply * duty                   logged, or sat(Kd (command - angle), +-umax)
//! external = load - m g l sin(angle - vertical)     J = N^2 Jm + m l^2
//! ```
//!
//! at the output shaft, `k` being `N` times the motor's torque constant. Friction is that of
//! [`friction`](super::friction): the torque that would stop the shaft, limited to its budget
//! (Duclusaud, Passault et al., arXiv 2410.08650). Names and units are those of the simulated
//! drivetrain; with a gear ratio of 1 all quantities refer to the output shaft.

mod shaft;

use std::sync::Arc;

use model_core::models::SetupParameters;
use model_core::parameter::Parameters;
use model_core::plant::drivetrain::{
    electrical::ElectricalParameters, friction::FrictionParameters,
    gear_train::GearTrainParameters, load::LoadParameters,
};

use super::Dynamics;
use super::friction::{has_coefficient, is_coefficient, neutral_value};
use super::initial_state::InitialState;
use crate::experiment::Experiment;
use crate::hybrid::{Output, simulate_steps};
use crate::model::{
    Description, Model, ModelParameter, NestedOptimum, ParameterValues, parameters,
};
use crate::recording::{Recording, RecordingError};
use crate::scalar::Scalar;
use crate::start::DataSummary;
use shaft::Shaft;

model_core::parameters! {
    /// Parameters that the simulated drivetrain does not have, or not as one number.
    pub struct RigParameters {
        /// Duty per error of the angle, of a servo that is a position loop.
        duty_per_error_pct_deg ["Kd"]: 10.0, "%/deg", 1e-4, 1e4, "full duty at 10 deg";
        /// Factor by which its firmware multiplies that: the gain that is set in a smart servo.
        firmware_gain ["kp"]: 1.0, "1", 1e-6, 1e6, "none";
        /// Greatest magnitude of the duty.
        duty_limit_pct ["umax"]: 100.0, "%", 1.0, 100.0, "the whole bridge";
        /// Measured angle at which the pendulum hangs straight down.
        vertical_deg [""]: 0.0, "deg", -180.0, 180.0, "the arm hangs at zero";
        /// Share by which a positive voltage drives more, and a negative one less.
        drive_asymmetry [""]: 0.0, "1", -0.9, 0.9, "none";
    }
}

/// The source of the motor voltage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drive {
    /// The logged duty.
    Duty,
    /// A position loop inside the servo, from the command.
    Position,
}

/// Motor, friction, pendulum.
#[derive(Debug, Clone)]
pub struct Motor {
    drive: Drive,
    /// Friction model, 1 to 6.
    friction: usize,
    parameters: Vec<ModelParameter>,
}

const INFINITY: f64 = f64::INFINITY;

/// The gear ratio of the simulator's drivetrain, which a fitted motor gets.
const RATIO: f64 = ModelParameter::of(<GearTrainParameters as Parameters>::TABLE, "gear_ratio")
    .parameter
    .default;

/// The least values at the output shaft of which the simulator has the values at the motor.
const LEAST_TORQUE_CONSTANT_NM_A: f64 = RATIO
    * ModelParameter::of(
        <ElectricalParameters as Parameters>::TABLE,
        "torque_constant_nm_a",
    )
    .parameter
    .min;
const LEAST_INERTIA_KG_M2: f64 = RATIO
    * RATIO
    * ModelParameter::of(
        <GearTrainParameters as Parameters>::TABLE,
        "motor_inertia_kg_m2",
    )
    .parameter
    .min;

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// The greatest viscous friction of a motor that is no servo, at the output of its gear: 100 Nm
/// s/rad.
const MOST_VISCOUS_NM_S_DEG: f64 = 100.0 * DEGREE;

parameters! {
    /// Parameters of [`Motor`]. The bounds of the friction coefficients of a servo are the ranges
    /// in which the authors of arXiv 2410.08650 search (github.com/Rhoban/bam, `bam/model.py`):
    /// beyond them a recording is fitted by friction that no servo has, and a held-out one is not
    /// predicted.
    pub struct MotorValues {
        torque_constant_nm_a: ElectricalParameters.redeclared(1.6, 1e-5, 100.0)
            .searched(LEAST_TORQUE_CONSTANT_NM_A, 100.0);
        winding_resistance_ohm: ElectricalParameters.redeclared(2.0, 1e-2, 1e3).fixed();
        motor_inertia_kg_m2: GearTrainParameters.redeclared(5e-3, 1e-10, 10.0)
            .searched(LEAST_INERTIA_KG_M2, 10.0);
        delay_s: SetupParameters;
        // The simulator describes it by a feed-forward gain of at most 100 %/(deg/s), behind a
        // position gain of 10 1/s.
        duty_per_error_pct_deg: RigParameters.searched(1e-4, 1e3);
        vertical_deg: RigParameters.fixed();
        duty_limit_pct: RigParameters.fixed();
        supply_v: ElectricalParameters.redeclared(12.0, 0.1, 1e3).fixed();
        gear_ratio: GearTrainParameters.redeclared(1.0, 1.0, 2000.0).fixed();
        pendulum_mass_kg: LoadParameters.fixed();
        pendulum_length_m: LoadParameters.fixed();
        load_torque_nm: LoadParameters.fixed();
        backlash_deg: GearTrainParameters.redeclared(0.0, 0.0, 20.0).fixed();
        drive_asymmetry: RigParameters.fixed();
        hard_stop_deg: GearTrainParameters.redeclared(INFINITY, 0.0, INFINITY).fixed();
        firmware_gain: RigParameters.fixed();
        coulomb_friction_nm: FrictionParameters;
        // Up to 1 Nm s/rad. It brakes as the back-EMF does: the two differ where the duty is at its
        // limit, or the motor off, and elsewhere one stands for the other.
        viscous_friction_nm_s_deg: FrictionParameters.searched(0.0, DEGREE).negligible();
        stribeck_friction_nm: FrictionParameters;
        // 0.1 to 1 rad/s.
        stribeck_rate_deg_s: FrictionParameters.searched(0.1 / DEGREE, 1.0 / DEGREE);
        stribeck_exponent: FrictionParameters.searched(1.0, 10.0);
        // Shares of the torques in motion, and of their squares at rest.
        load_friction_motor: FrictionParameters.searched(0.0, 0.5);
        load_friction_external: FrictionParameters.searched(0.0, 0.5);
        load_stribeck_motor: FrictionParameters;
        load_stribeck_external: FrictionParameters;
        load_quadratic_motor_1_nm: FrictionParameters.searched(0.0, 0.01);
        load_quadratic_external_1_nm: FrictionParameters.searched(0.0, 0.01);
        initial_angle_deg: InitialState.initial_state();
        initial_rate_deg_s: InitialState.initial_state().fixed();
    }
}

impl Motor {
    /// The motor with friction model `friction`, 1 to 6.
    pub fn new(drive: Drive, friction: usize) -> Self {
        let mut parameters = MotorValues::<f64>::TABLE.to_vec();
        for p in &mut parameters {
            // Only k/R and, with the viscous friction, k^2/R are observable: R is to be measured.
            p.is_fixed |= match p.name {
                "duty_per_error_pct_deg" => drive == Drive::Duty,
                name => !has_coefficient(friction, name),
            };
            if drive == Drive::Duty && p.name == "viscous_friction_nm_s_deg" {
                p.bounds.1 = MOST_VISCOUS_NM_S_DEG;
            }
        }
        Self {
            drive,
            friction,
            parameters,
        }
    }
}

pub(super) fn models() -> Vec<Arc<dyn Model>> {
    let of_drive = |drive| (1..=6).map(move |m| Arc::new(Motor::new(drive, m)) as Arc<dyn Model>);
    [Drive::Duty, Drive::Position]
        .into_iter()
        .flat_map(of_drive)
        .collect()
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

    fn parameters(&self) -> &[ModelParameter] {
        &self.parameters
    }

    fn accepts(&self, recording: &Recording) -> Result<(), RecordingError> {
        match (self.drive, &recording.duty_pct) {
            (Drive::Duty, None) => Err(RecordingError::Missing("duty_pct")),
            _ => Ok(()),
        }
    }

    fn unmeasured(&self, recording: &Recording) -> Option<&'static str> {
        // The torque constant is found in proportion to it. A position loop has it in its gain.
        let mut measured = recording.supply_v.iter().flatten();
        let is_known =
            measured.any(|volts| volts.is_finite()) || recording.constants.contains_key("supply_v");
        (self.drive == Drive::Duty && !is_known).then_some("supply_v")
    }

    fn nested_models(&self) -> Vec<Arc<dyn Model>> {
        let nested: &[usize] = match self.friction {
            1 => &[],
            2 | 3 => &[1],
            4 => &[2, 3],
            5 => &[4],
            _ => &[5],
        };
        let model = |friction: &usize| Arc::new(Self::new(self.drive, *friction)) as _;
        nested.iter().map(model).collect()
    }

    fn contains_nested_models_exactly(&self) -> bool {
        true
    }

    fn value_from_nested(&self, name: &str, nested: &NestedOptimum<'_>) -> Option<f64> {
        let is_additional = nested.model.is_fixed_by_default(name)
            && !self.is_fixed_by_default(name)
            && is_coefficient(name);
        match is_additional {
            true => neutral_value(name, nested),
            false => nested.value(name),
        }
    }

    fn has_friction(&self) -> bool {
        true
    }

    fn has_many_minima(&self) -> bool {
        true
    }
}

impl Dynamics for Motor {
    type Parameters<S: Scalar> = MotorValues<S>;

    fn start(&self, experiments: &[Experiment]) -> MotorValues<f64> {
        let data = DataSummary::of(experiments);
        let defaults = MotorValues::<f64>::defaults();
        // The fastest rate of the recordings is at most the no-load rate.
        let fastest_rad_s = data.rate_up_deg_s.max(data.rate_down_deg_s).to_radians();
        let supply_v = experiments.first().and_then(|e| e.supply_v);
        let supply_v = supply_v.unwrap_or(defaults.supply_v);
        let gains = experiments.iter();
        let gains = gains.filter_map(|e| e.recording.constants.get("firmware_gain"));
        let greatest = gains.fold(0.0_f64, |greatest, gain| greatest.max(*gain));
        let firmware_gain = if greatest > 0.0 { greatest } else { 1.0 };
        MotorValues {
            delay_s: match self.drive {
                Drive::Duty => 0.005,
                Drive::Position => 0.2 * data.lag_s,
            },
            torque_constant_nm_a: (0.6 * supply_v / fastest_rad_s.max(0.1)).clamp(0.05, 20.0),
            duty_per_error_pct_deg: defaults.duty_per_error_pct_deg / firmware_gain,
            supply_v,
            initial_angle_deg: data.initial_angle_deg,
            ..defaults
        }
    }

    fn run<S: Scalar>(&self, run: &Experiment, p: &MotorValues<S>, output: &mut impl Output<S>) {
        let is_known = run.recording.constants.contains_key("supply_v");
        let supply = match run.supply_v {
            Some(mean_v) if !is_known => S::constant(mean_v),
            _ => p.supply_v,
        };
        let mut shaft = Shaft::new(self.friction, p, supply, self.drive == Drive::Position);
        if run.is_preview {
            shaft = shaft.in_longer_steps();
        }
        let input = match self.drive {
            Drive::Duty => &run.drive,
            Drive::Position => &run.command,
        };
        simulate_steps(&mut shaft, run, input, p.delay_s, output);
    }
}
