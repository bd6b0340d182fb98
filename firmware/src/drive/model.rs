//! A motor model that runs beside the motor in single precision, and its error, the residual.
//!
//! ```text
//! J w' = n k (u - n k w)/R - b w - c sign(w)        at the output shaft, w in rad/s
//! a'   = w + (a_measured - a)/T
//! residual = a_measured - a
//! ```
//!
//! One step a control period, implicit in `w` and therefore stable for all parameters. The rate is
//! predicted from the voltage alone. The angle is corrected toward the measured angle with the time
//! constant `T`, so that a rate error `d` gives a residual of `d T` and not an unbounded one.

use model_core::control::units::Angle;

use crate::{
    application::{Bridge, Outputs},
    parameters::ModelSettings,
    timing::{CONTROL_PERIOD_MS, thousandths},
};

/// A control period, s.
const PERIOD_S: f32 = CONTROL_PERIOD_MS as f32 * 1e-3;

/// Degrees per radian.
const DEG: f32 = 180.0 / core::f32::consts::PI;

/// State of the model.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct MotorModel {
    rate_rad_s: f32,
    angle_deg: f32,
    residual_deg: f32,
}

impl MotorModel {
    /// The predicted angle, deg.
    pub fn angle_deg(&self) -> f32 {
        self.angle_deg
    }

    /// The predicted rate, deg/s.
    pub fn rate_deg_s(&self) -> f32 {
        self.rate_rad_s * DEG
    }

    /// The measured angle minus the predicted one, deg.
    pub fn residual_deg(&self) -> f32 {
        self.residual_deg
    }

    /// One control period.
    pub fn step(&mut self, settings: &ModelSettings, outputs: &Outputs) {
        let measured_deg = degrees(outputs.telemetry.angle);
        if settings.model_selection == 0 {
            *self = Self {
                angle_deg: measured_deg,
                ..Self::default()
            };
            return;
        }
        self.rate_rad_s = self.next_rate(settings, outputs);
        self.residual_deg = measured_deg - self.angle_deg;
        let correction = PERIOD_S / (settings.correction_time_s + PERIOD_S);
        self.angle_deg += self.rate_deg_s() * PERIOD_S + self.residual_deg * correction;
    }

    fn next_rate(&self, settings: &ModelSettings, outputs: &Outputs) -> f32 {
        let constant = settings.torque_constant_nm_a * settings.gear_ratio;
        let conductance = 1.0 / settings.resistance_ohm;
        let (drive, braking) = match outputs.bridge {
            // No current flows.
            Bridge::Coast => (0.0, 0.0),
            Bridge::Brake => (0.0, constant * constant * conductance),
            Bridge::Driven(_) => {
                let duty = thousandths(outputs.telemetry.duty) as f32 * 1e-5;
                let volts = duty * outputs.telemetry.supply_mv as f32 * 1e-3;
                let braking = constant * constant * conductance;
                (constant * conductance * volts, braking)
            }
        };
        let damping = braking + settings.viscous_friction_nm_s;
        let gain = PERIOD_S / settings.inertia_kg_m2;
        let free = self.rate_rad_s + gain * drive;
        // Coulomb friction stops the motion and never reverses it.
        let friction = gain * settings.coulomb_friction_nm;
        let left = if free > friction {
            free - friction
        } else if free < -friction {
            free + friction
        } else {
            0.0
        };
        left / (1.0 + gain * damping)
    }
}

fn degrees(angle: Angle) -> f32 {
    thousandths(angle) as f32 * 1e-3
}
