//! A model of the motor that runs beside it, in single precision, and what it is wrong by: the residual.
//!
//! ```text
//! J w' = n k (u - n k w)/R - b w - c sign(w)        all at the output shaft, w in rad/s
//! a'   = w + (a_measured - a)/T
//! residual = a_measured - a
//! ```
//!
//! One step a control period, implicit in `w`, so that it is stable for all parameters. The rate is predicted from the voltage alone;
//! the angle is drawn to the measured one with the correction time `T`, so that a model whose rate is off by `d` has a residual of
//! `d T`, and not one that grows for ever.

use model_core::control::units::Angle;

use super::kept::{Kept, Slot};
use crate::{
    application::{Bridge, Outputs},
    timing::{CONTROL_PERIOD_MS, thousandths},
};

/// A control period, s.
const PERIOD_S: f32 = CONTROL_PERIOD_MS as f32 * 1e-3;

/// Degrees in a radian.
const DEG: f32 = 180.0 / core::f32::consts::PI;

/// What the model remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Model {
    rate_rad_s: f32,
    angle_deg: f32,
    residual_deg: f32,
}

impl Model {
    /// The predicted angle, deg.
    pub fn angle_deg(&self) -> f32 {
        self.angle_deg
    }

    /// The predicted rate, deg/s.
    pub fn rate_deg_s(&self) -> f32 {
        self.rate_rad_s * DEG
    }

    /// What the measured angle has more than the predicted one, deg.
    pub fn residual_deg(&self) -> f32 {
        self.residual_deg
    }

    /// One control period, of 2010h:2 and the objects 2011h.
    pub fn step(&mut self, kept: &Kept, outputs: &Outputs) {
        let measured_deg = degrees(outputs.telemetry.angle);
        if kept.get(Slot::Model) == 0 {
            *self = Self {
                angle_deg: measured_deg,
                ..Self::default()
            };
            return;
        }
        self.rate_rad_s = self.next_rate(kept, outputs);
        self.residual_deg = measured_deg - self.angle_deg;
        let correction = PERIOD_S / (kept.real(Slot::Correction) + PERIOD_S);
        self.angle_deg += self.rate_deg_s() * PERIOD_S + self.residual_deg * correction;
    }

    fn next_rate(&self, kept: &Kept, outputs: &Outputs) -> f32 {
        let constant = kept.real(Slot::TorqueConstant) * kept.real(Slot::GearRatio);
        let conductance = 1.0 / kept.real(Slot::Resistance);
        let inertia = kept.real(Slot::Inertia);
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
        let damping = braking + kept.real(Slot::Viscous);
        let gain = PERIOD_S / inertia;
        let free = self.rate_rad_s + gain * drive;
        // Friction stops, and does not turn around.
        let friction = gain * kept.real(Slot::Coulomb);
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
