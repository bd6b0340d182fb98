//! What a loop is measured on: a motor, and the voltage of its source.

use model_core::plant::board::BoardPlantOptions;

use super::drive::Drive;
use super::{SOURCE_V, Setup, fitted};

/// A bench.
#[derive(Debug, Clone, Copy, Default)]
pub struct Bench {
    /// Voltage of the source, V; without it that of the seed.
    pub source_v: Option<f64>,
    /// Whether the motor is the fitted one.
    pub is_fitted: bool,
}

impl Bench {
    /// With the paper's motor and the supplies of the seeds.
    pub const USUAL: Self = Self {
        source_v: None,
        is_fitted: false,
    };

    /// With the fitted motor.
    pub const FITTED: Self = Self {
        is_fitted: true,
        ..Self::USUAL
    };

    /// With this voltage of the source, V.
    pub const fn at(source_v: f64) -> Self {
        Self {
            source_v: Some(source_v),
            ..Self::USUAL
        }
    }

    /// Share of a duty of the usual bench that makes no greater current here, at a shaft at rest.
    pub fn duty_share(self) -> f64 {
        let usual = BoardPlantOptions::realistic(0).drivetrain.electrical;
        let (motor, source_v) = match self.is_fitted {
            true => (fitted::motor(), fitted::motor().supply_v),
            false => (usual, self.source_v.unwrap_or(SOURCE_V)),
        };
        let usual_a = SOURCE_V / usual.winding_resistance_ohm;
        (usual_a * motor.winding_resistance_ohm / source_v).min(1.0)
    }

    /// The drive of a seed, whose targets come so many ms apart.
    pub fn drive(self, setup: &Setup, seed: u64, interval_ms: i32) -> Drive {
        let mut drive = match self.is_fitted {
            true => fitted::drive(setup, seed, interval_ms),
            false => setup.drive_on(&BoardPlantOptions::realistic(seed), interval_ms),
        };
        if self.source_v.is_some() {
            drive.defects().source_v = self.source_v;
        }
        drive
    }
}
