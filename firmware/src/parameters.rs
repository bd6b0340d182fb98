//! Everything of the board that can be set, in one typed set.

mod by_number;
pub mod integers;
mod motion;
#[cfg(test)]
mod tests;

use model_core::control::{cascade::Coefficients, parameters::ControlParameters};

pub use crate::{
    command::{bus::CommandSettings, servo::ServoSettings},
    protection::{
        current::CurrentLimits, encoder::EncoderLimits, following::FollowingLimits,
        stall::StallLimits, supply::SupplyLimits, temperature::TemperatureLimits,
        timing::TimingLimits,
    },
};
pub use by_number::{CONTROL, Meaning, Value, WORDS};
pub use motion::{BusSettings, StopSettings};

/// All parameters of the board.
///
/// The integers lie one behind the other in the order of their numbers, so that all of them are copied at once.
#[repr(C)]
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

    /// Checks every integer against its range, and all against each other. Coefficients of the
    /// control step cannot be out of theirs.
    ///
    /// | rule | because |
    /// |---|---|
    /// | `pulse_min_us` < `pulse_centre_us` < `pulse_max_us` | angles are shares of both halves |
    /// | `bit_rate_kbit_s` is 500 or 1000 | the timing of the bits is made for these |
    /// | `under_voltage_mv` < `over_voltage_mv` | some voltage has to be right |
    /// | `continuous_ma` <= `over_current_ma` | what is borne for ever must be allowed |
    ///
    /// # Errors
    /// The number of the first parameter that is not possible.
    pub fn check(&self) -> Result<(), u8> {
        if let Some(number) = self.out_of_range() {
            return Err(number);
        }
        let servo = &self.servo;
        let is_ordered = servo.pulse_min_us < servo.pulse_centre_us
            && servo.pulse_centre_us < servo.pulse_max_us;
        let rules = [
            (is_ordered, PULSE_CENTRE),
            (matches!(self.bus.bit_rate_kbit_s, 500 | 1000), BIT_RATE),
            (
                self.supply.under_voltage_mv < self.supply.over_voltage_mv,
                UNDER_VOLTAGE,
            ),
            (
                self.current.continuous_ma <= self.current.over_current_ma,
                CONTINUOUS,
            ),
        ];
        match rules.into_iter().find(|(holds, _)| !holds) {
            Some((_, number)) => Err(number),
            None => Ok(()),
        }
    }
}

// Numbers that the rules name; a test holds them to their names.
const PULSE_CENTRE: u8 = 21;
const BIT_RATE: u8 = 26;
const CONTINUOUS: u8 = 36;
const UNDER_VOLTAGE: u8 = 44;

impl Default for BoardParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}
