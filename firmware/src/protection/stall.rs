//! The shaft does not turn while the motor pulls.
//!
//! Standing is judged by the way since the motor began to pull, not by the rate: a count that
//! flickers at its edge is a rate of 9 deg/s, and no way.

use model_core::control::units::Angle;

use super::{Conditions, lasting::Lasting};
use crate::{parameters::StallLimits, timing::angle_of_mdeg};

/// For how long the shaft has stood, and where.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct StallGuard {
    lasting: Lasting,
    place: Angle,
}

impl StallGuard {
    /// For how many control periods the motor has stalled.
    pub fn periods(&self) -> u16 {
        self.lasting.periods()
    }

    /// Whether the motor has stalled.
    pub fn check(&mut self, limits: &StallLimits, c: &Conditions<'_>) -> bool {
        // An angle that is not known says nothing of the way.
        let is_known = c.measured.travelled.is_some();
        let current = c.measured.current.filter(|_| is_known);
        let stalls = current.map(|current| {
            let pulls = c.is_driving && current.mean_ma.abs() >= limits.stall_current_ma;
            pulls && self.stands(limits, c.angle)
        });
        if stalls == Some(false) {
            // A slow shaft stands within the way for most of the time.
            *self = Self {
                place: c.angle,
                ..Self::default()
            };
        }
        self.lasting.update(stalls, limits.stall_ms)
    }

    fn stands(&self, limits: &StallLimits, angle: Angle) -> bool {
        // Both within 2^15 deg.
        let way = angle - self.place;
        let end = angle_of_mdeg(limits.stall_way_mdeg);
        way <= end && way >= -end
    }
}
