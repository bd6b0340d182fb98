//! The shaft does not turn while the motor pulls.
//!
//! The current is that of a motor that stands, whose error by the resistance is the smallest: see
//! [`crate::measure::PeriodCurrent`].
//!
//! Standing is judged by the way since the motor began to pull, not by the rate: a count that
//! flickers at its edge is a rate of 9 deg/s, and no way.
//!
//! A sample that contradicts decrements the counter and does not clear it, as in all other
//! protections: otherwise a jam that releases the shaft for 20 of each 100 ms is never reported.
//! A slow shaft is within the way for most of the time as well. The two differ in the time that a
//! quarter of the way takes. Where that is less than a sixth of `stall_ms`, the quarter was motion,
//! and once the shaft leaves the way, its control periods count down instead of up.

use model_core::control::encoder_word::COUNTS_PER_TURN;

use super::{Conditions, lasting::Lasting};
use crate::{parameters::StallLimits, timing::periods};

/// A quarter of the way is motion if it takes less than this share of the stall time: by the
/// defaults three counts in 80 ms, 3.3 deg/s, so that a jam of 80 ms is none.
const MOTION: u16 = 6;

/// For how long the shaft has stood.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct StallGuard {
    lasting: Lasting,
    way: Way,
}

/// The way of the shaft since the motor began to pull, or since it left the last one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Way {
    /// Counts of the encoder.
    counts: i32,
    /// Those of the present quarter, and its control periods.
    quarter: i32,
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
        let samples = c.measured.current.zip(c.measured.travelled);
        let stalls = samples.map(|(current, travelled)| {
            let pulls = c.is_driving && current.standing_ma.abs() >= limits.stall_current_ma;
            pulls && self.way.holds(limits, travelled)
        });
        if stalls == Some(false) {
            self.lasting.take_back(self.way.moved);
            self.way = Way::default();
        }
        self.lasting.update(stalls, limits.stall_ms)
    }
}

impl Way {
    /// Whether the shaft is still within the way, these counts and one control period later.
    fn holds(&mut self, limits: &StallLimits, travelled: i32) -> bool {
        // At most 90,000 mdeg.
        let end = limits.stall_way_mdeg * COUNTS_PER_TURN / 360_000;
        // Up to the way, and half a turn.
        self.counts += travelled;
        self.quarter += travelled;
        self.periods = self.periods.saturating_add(1);
        if 4 * self.quarter.abs() > end {
            if self.periods < periods(limits.stall_ms) / MOTION {
                self.moved = self.moved.saturating_add(self.periods);
            }
            (self.quarter, self.periods) = (0, 0);
        }
        self.counts.abs() <= end
    }
}
