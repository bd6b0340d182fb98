//! The outer loop: a pure gain from the error of the angle to a commanded rate.

use super::{
    arithmetic::Gain,
    units::{Angle, Rate, limit, limit_between},
};

/// Limit of every commanded rate: three times what the encoder can follow.
pub(crate) const RATE_END: Rate = Rate::from_int(1 << 17);

/// Coefficients of the position loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PositionLoop<const VECTOR: bool = false> {
    /// P, 1/s, below 2^9.
    pub gain: Gain<Angle, Rate, VECTOR>,
    /// Least command, within 2^15 deg.
    pub min: Angle,
    /// Greatest command, not below `min`, within 2^15 deg.
    pub max: Angle,
    /// Greatest rate upward, 0 to 2^17 deg/s.
    pub rate_up: Rate,
    /// Greatest rate downward, 0 to 2^17 deg/s.
    pub rate_down: Rate,
}

/// The commanded rate, input of the rate loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RateCommand {
    /// The commanded rate.
    pub rate: Rate,
    /// Whether a position limit changed the command.
    pub position_limited: bool,
    /// Whether a rate limit changed the rate.
    pub rate_limited: bool,
}

impl<const VECTOR: bool> PositionLoop<VECTOR> {
    /// The commanded rate for a commanded and a measured angle.
    #[inline(always)]
    pub fn follow_angle(&self, command: Angle, angle: Angle) -> RateCommand {
        let mut target = command;
        let position_limited = limit(&mut target, self.min, self.max);
        // Both lie within 2^15 deg, so the error lies within 2^16 and P times it within 2^25.
        let mut rate = self.gain.times(target - angle);
        let rate_limited = limit_between(&mut rate, self.rate_down, self.rate_up);
        RateCommand {
            rate,
            position_limited,
            rate_limited,
        }
    }

    /// The commanded rate with the rate of the command, within 2^22 deg/s, which does not act
    /// beyond a position limit.
    pub fn with_rate(&self, command: RateCommand, forward: Rate) -> RateCommand {
        if command.position_limited {
            return command;
        }
        let mut rate = command.rate + forward;
        let rate_limited = limit_between(&mut rate, self.rate_down, self.rate_up);
        RateCommand {
            rate,
            rate_limited: rate_limited || command.rate_limited,
            ..command
        }
    }

    /// The commanded rate for a rate setpoint: towards a position limit at most the rate with which
    /// the loop approaches it. Without a gain the limit acts once the angle has reached it.
    pub fn follow_rate(&self, command: Rate, angle: Angle) -> RateCommand {
        let mut rate = command;
        let (low, high) = (
            self.approach(self.min, angle),
            self.approach(self.max, angle),
        );
        // The limits end at zero: beyond one of them the shaft is not driven back.
        let high = if high < Rate::ZERO { Rate::ZERO } else { high };
        let low = if low > Rate::ZERO { Rate::ZERO } else { low };
        let position_limited = limit(&mut rate, low, high);
        let rate_limited = limit_between(&mut rate, self.rate_down, self.rate_up);
        RateCommand {
            rate,
            position_limited,
            rate_limited,
        }
    }

    /// The rate with which the loop approaches an end of the range.
    fn approach(&self, end: Angle, angle: Angle) -> Rate {
        let distance = end - angle;
        if self.gain != Gain::default() {
            return self.gain.times(distance);
        }
        if distance > Angle::ZERO {
            RATE_END
        } else if distance < Angle::ZERO {
            -RATE_END
        } else {
            Rate::ZERO
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::units::{angle, rate};

    fn position_loop(gain: f64) -> PositionLoop {
        PositionLoop {
            gain: Gain::new(gain),
            min: angle(-10.0),
            max: angle(10.0),
            rate_up: rate(200.0),
            rate_down: rate(300.0),
        }
    }

    #[test]
    fn a_rate_setpoint_slows_down_before_a_position_limit_and_stops_at_it() {
        let with_gain = position_loop(8.0);
        for (command, at, expected) in [
            (100.0, 0.0, 80.0),
            (100.0, 9.0, 8.0),
            (100.0, 10.0, 0.0),
            (100.0, 11.0, 0.0),
            (-100.0, 11.0, -100.0),
            (-100.0, -9.0, -8.0),
        ] {
            let limited = with_gain.follow_rate(rate(command), angle(at));
            assert_eq!(limited.rate, rate(expected), "{command} at {at}");
            assert_eq!(limited.position_limited, command != expected);
        }
        let without_gain = position_loop(0.0);
        for (at, expected) in [(9.9, 100.0), (10.0, 0.0), (10.1, 0.0)] {
            let limited = without_gain.follow_rate(rate(100.0), angle(at));
            assert_eq!(limited.rate, rate(expected), "at {at}");
        }
    }

    #[test]
    fn the_rate_of_a_moving_angle_is_added_within_the_limits() {
        let position_loop = position_loop(8.0);
        let follow = |command, forward| {
            let command = position_loop.follow_angle(angle(command), angle(0.0));
            position_loop.with_rate(command, rate(forward))
        };
        assert_eq!(follow(5.0, 100.0).rate, rate(140.0));
        assert_eq!(follow(-5.0, 100.0).rate, rate(60.0));
        let fast = follow(5.0, 300.0);
        assert!(fast.rate == rate(200.0) && fast.rate_limited);
        // At a position limit the command rests.
        let beyond = follow(11.0, 100.0);
        assert!(beyond.rate == rate(80.0) && beyond.position_limited);
    }
}
