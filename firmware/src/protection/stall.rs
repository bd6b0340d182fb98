//! The shaft does not turn while the motor pulls.
//!
//! Standing is judged by the way since the motor began to pull, not by the rate: a count that
//! flickers at its edge is a rate of 9 deg/s, and no way.
//!
//! A sample that contradicts decrements the counter and does not clear it, as in all other
//! protections: otherwise a jam that releases the shaft for 20 of each 100 ms is never reported.
//! A slow shaft is within the way for most of the time as well. The two differ in the time that a
//! quarter of the way takes. Where that is less than a sixth of `stall_ms`, the quarter was motion,
//! and once the shaft leaves the way, its control periods count down instead of up.

use model_core::control::units::Angle;

use super::{Conditions, lasting::Lasting};
use crate::{
    parameters::StallLimits,
    timing::{angle_of_mdeg, periods},
};

/// A quarter of the way is motion if it takes less than this share of the stall time: by the
/// defaults three counts in 80 ms, 3.3 deg/s, so that a jam of 80 ms is none.
const MOTION: u16 = 6;

/// For how long the shaft has stood, and where.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct StallGuard {
    lasting: Lasting,
    way: Way,
}

/// The way of the shaft since the motor began to pull, or since it left the last one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Way {
    start: Angle,
    /// Start of the present quarter, and control periods since then.
    quarter: Angle,
    periods: u16,
    /// Control periods of the quarters that were motion.
    moved: u16,
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
            pulls && self.way.holds(limits, c.angle)
        });
        if stalls == Some(false) {
            self.lasting.take_back(self.way.moved);
            self.way = Way {
                start: c.angle,
                quarter: c.angle,
                ..Way::default()
            };
        }
        self.lasting.update(stalls, limits.stall_ms)
    }
}

impl Way {
    /// Whether the shaft is still within the way, one control period later.
    fn holds(&mut self, limits: &StallLimits, angle: Angle) -> bool {
        let end = angle_of_mdeg(limits.stall_way_mdeg);
        self.periods = self.periods.saturating_add(1);
        if !is_within(angle - self.quarter, Angle::from_bits(end.to_bits() >> 2)) {
            if self.periods < periods(limits.stall_ms) / MOTION {
                self.moved = self.moved.saturating_add(self.periods);
            }
            (self.quarter, self.periods) = (angle, 0);
        }
        is_within(angle - self.start, end)
    }
}

/// Whether a difference of angles, both within 2^15 deg, is at most this far from zero.
fn is_within(way: Angle, end: Angle) -> bool {
    way <= end && way >= -end
}
