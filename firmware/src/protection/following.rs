//! The shaft does not follow the setpoint.
//!
//! A commanded angle may step, and no shaft can: the difference alone is not a criterion. A shaft follows
//! an angle if it is near it or approaches it:
//!
//! ```text
//! |command - angle| <= following_window_mdeg
//! or rate sign(command - angle) >= following_rate_deg_s
//! ```
//!
//! or half of the commanded rate, if its limit or a low gain makes that less.
//!
//! For a commanded rate there is no difference of angles (CiA 402 defines the following error for
//! the position modes). The shaft follows a rate of at least `following_rate_deg_s` if it turns in
//! its direction with `following_rate_deg_s` or half of the commanded rate, whichever is less.
//! Slower rates are not monitored: an estimate from single counts is too coarse.
//!
//! Not following for `following_ms` longer than following is [`Fault::FollowingError`].
//!
//! [`Fault::FollowingError`]: crate::faults::Fault::FollowingError

use model_core::control::units::{Angle, Rate};

use super::{Conditions, lasting::Lasting};
use crate::{parameters::FollowingLimits, timing::angle_of_mdeg};

/// For how long the shaft has not followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct FollowingGuard(Lasting);

impl FollowingGuard {
    /// For how many control periods the shaft has not followed.
    pub fn periods(&self) -> u16 {
        self.0.periods()
    }

    /// Whether the fault is present.
    pub fn check(&mut self, limits: &FollowingLimits, c: &Conditions<'_>) -> bool {
        // Without a valid count nothing is known.
        let deviates = c.measured.travelled.map(|_| deviates(limits, c));
        self.0.update(deviates, limits.following_ms)
    }
}

fn deviates(limits: &FollowingLimits, c: &Conditions<'_>) -> bool {
    if !c.is_following {
        return false;
    }
    let expected = Rate::from_int(limits.following_rate_deg_s);
    // Within 2^17 deg/s.
    let half = Rate::from_bits(c.rate_command.to_bits().abs() >> 1);
    let least = half.at_most(expected);
    let turns = |is_upward: bool| {
        if is_upward {
            c.rate >= least
        } else {
            c.rate <= -least
        }
    };
    match c.setpoint.angle() {
        Some(command) => {
            let window = angle_of_mdeg(limits.following_window_mdeg);
            let error = command.saturating_sub(c.angle);
            let is_off = error > window || error < -window;
            is_off && !turns(error > Angle::ZERO)
        }
        None => c.rate_command.abs() >= expected && !turns(c.rate_command > Rate::ZERO),
    }
}

#[cfg(test)]
mod tests {
    use model_core::control::units::angle;

    use super::*;
    use crate::protection::tests::{UNMEASURED, driven};

    /// Whether a shaft at zero, at this rate, deviates from an angle that is commanded.
    fn deviates_from(command: Angle, rate_deg_s: i32) -> bool {
        let limits = FollowingLimits {
            following_window_mdeg: 10_000,
            following_rate_deg_s: 20,
            ..FollowingLimits::DEFAULT
        };
        let conditions = Conditions {
            setpoint: command.into(),
            rate_command: Rate::from_int(80),
            rate: Rate::from_int(rate_deg_s),
            ..driven(&UNMEASURED)
        };
        deviates(&limits, &conditions)
    }

    #[test]
    fn a_resting_shaft_deviates_from_an_angle_outside_the_window() {
        for sign in [1, -1] {
            let edge = Angle::from_int(10 * sign);
            assert!(!deviates_from(edge, 0));
            let beyond = Angle::from_bits(edge.to_bits() + i64::from(sign));
            assert!(deviates_from(beyond, 0));
            assert!(deviates_from(angle(90.0 * f64::from(sign)), 0));
        }
    }

    #[test]
    fn a_shaft_follows_a_distant_angle_if_it_approaches_it_at_the_least_rate() {
        for sign in [1, -1] {
            let command = Angle::from_int(90 * sign);
            assert!(!deviates_from(command, 20 * sign));
            assert!(deviates_from(command, 19 * sign));
            assert!(deviates_from(command, -20 * sign));
        }
    }
}
