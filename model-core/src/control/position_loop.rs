//! The outer loop: a pure gain from the error of the angle to a commanded rate.

use super::{
    arithmetic::Coefficient,
    units::{Angle, Rate, hold, hold_between},
};

/// No commanded rate is greater: thrice what the encoder can follow.
pub(crate) const WIDEST_RATE: Rate = Rate::const_from_int(1 << 17);

/// Coefficients of the position loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PositionLoop {
    /// P, 1/s, below 2^9.
    pub gain: Coefficient,
    /// Least command, within 2^15 deg.
    pub min: Angle,
    /// Greatest command, not below `min`, within 2^15 deg.
    pub max: Angle,
    /// Greatest rate upward, 0 to 2^17 deg/s.
    pub rate_up: Rate,
    /// Greatest rate downward, 0 to 2^17 deg/s.
    pub rate_down: Rate,
}

/// What the position loop asks of the rate loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RateCommand {
    /// The commanded rate.
    pub rate: Rate,
    /// Whether a position limit held the command back.
    pub position_limited: bool,
    /// Whether a rate limit held the rate back.
    pub rate_limited: bool,
}

impl PositionLoop {
    /// The commanded rate for a commanded and a measured angle.
    #[inline(always)]
    pub fn rate_command(&self, command: Angle, angle: Angle) -> RateCommand {
        let mut target = command;
        let position_limited = hold(&mut target, self.min, self.max);
        // Both lie within 2^15 deg, so the error lies within 2^16 and P times it within 2^25.
        let error = target - angle;
        let mut rate = self.gain.times(error);
        let rate_limited = hold_between(&mut rate, self.rate_down, self.rate_up);
        RateCommand {
            rate,
            position_limited,
            rate_limited,
        }
    }
}
