//! The shaft does not follow the command.
//!
//! A command may step, and no shaft can: the plain difference of both says little. A shaft follows
//! if it is near the command, or on its way there:
//!
//! ```text
//! |command - angle| <= following_window_mdeg
//! or rate sign(command - angle) >= following_rate_deg_s
//! ```
//!
//! or half of the commanded rate, where its limit or a weak gain make that the less.
//!
//! Neither of them for `following_ms` in a row is [`Fault::FollowingError`].
//!
//! [`Fault::FollowingError`]: crate::faults::Fault::FollowingError

use model_core::control::units::{ANGLE_END, Angle, Rate, held};

use super::{Conditions, lasting::Lasting};
use crate::{parameters::FollowingLimits, timing::angle_of_mdeg};

/// For how long the shaft has not followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct FollowingGuard(Lasting);

impl FollowingGuard {
    /// Whether it has been too long.
    pub fn check(&mut self, limits: &FollowingLimits, c: &Conditions<'_>) -> bool {
        // An angle that is not known says nothing.
        let strays = c.measured.travelled.map(|_| strays(limits, c));
        self.0.update(strays, limits.following_ms)
    }
}

fn strays(limits: &FollowingLimits, c: &Conditions<'_>) -> bool {
    let window = angle_of_mdeg(limits.following_window_mdeg);
    // Both within 2^15 deg.
    let error = held(c.command, ANGLE_END) - c.angle;
    let wanted = Rate::from_bits(i64::from(limits.following_rate_deg_s) << 32);
    // Within 2^17 deg/s.
    let half = Rate::from_bits(c.rate_command.to_bits().abs() >> 1);
    let least = if half < wanted { half } else { wanted };
    let comes_nearer = if error > Angle::ZERO {
        c.rate >= least
    } else {
        c.rate <= -least
    };
    let is_off = error > window || error < -window;
    c.is_following && is_off && !comes_nearer
}
