//! The motor's travel by its back-EMF, with gaps.
//!
//! In a gap, where the diodes carry the winding's current until the scan, there is no back-EMF. The
//! travel of a short gap follows from the rates before and behind it; that of a longer one is not
//! known. Nor is it until two scans behind a gap agree: legs that have not settled show a rate that
//! the motor does not have.

use model_core::time::CONTROL_PERIODS_PER_WINDOW;

use super::per_period;
use crate::timing::periods;

/// Greatest rate that is expected, mdeg/s: 2,097 deg/s.
const END: i32 = 1 << 21;

/// Control periods from one back-EMF to the next of which the travel is known, where scans between
/// them have none and both rates are within [`GREATEST_CHANGE`]: a motor whose rate changes in one
/// direction between them has turned within `40 deg/s x 16 ms/2` = 0.32 deg of the mean.
pub(super) const BRIDGED: i32 = periods(16) as i32;

/// Change of the rate from a scan to the next, mdeg/s: a motor of 130 % of the constant and 70 % of
/// the resistance reverses with 8,000 deg/s^2, and a load of 0.8 N m on the motor's inertia adds
/// 2,000 deg/s^2. Behind a gap, in which the diodes have carried the winding's current until the
/// scan, it may end shortly before the scan: legs that have not settled then differ by more.
const GREATEST_CHANGE: i32 = 40_000;

/// Control periods of a gap that are counted: those between two scans, at most.
const LONGEST: i32 = periods(1_024) as i32;

/// Whether there are control periods without a scan.
const HOLDS: bool = CONTROL_PERIODS_PER_WINDOW > 1;

/// Greatest travel that is expected.
const FURTHEST: i32 = per_period(END) * LONGEST;

/// Control periods without a valid count, or without a back-EMF, that are counted.
const MOST_PERIODS: i32 = periods(192) as i32;

/// The rate at the last back-EMF, mdeg/s.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum LastRate {
    /// There was none.
    #[default]
    Unknown,
    /// There was a gap behind it, or the legs have not settled since one.
    Unsettled(i32),
    Settled(i32),
}

/// The motor's travel since the last comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct MotorTravel {
    /// In parts of a mdeg.
    pub expected: i32,
    /// Control periods since then, and those of them whose travel is not known.
    pub periods: i32,
    unknown: i32,
    last: LastRate,
    /// Control periods since the last back-EMF.
    gap: i32,
}

impl MotorTravel {
    /// A control period with this rate, mdeg/s, after so many that did not run. Returns by how much
    /// the rate has changed since the last one, if that is known.
    pub fn advance(&mut self, rate: Option<i32>, missed: u8) -> Option<i32> {
        self.pass(missed);
        let Some(now) = rate.map(|rate| rate.clamp(-END, END)) else {
            if let LastRate::Settled(before) = self.last {
                self.last = LastRate::Unsettled(before);
            }
            return None;
        };
        let is_near = |before: i32| (now - before).abs() <= GREATEST_CHANGE;
        let before = match self.last {
            LastRate::Settled(before) => Some(before),
            LastRate::Unsettled(before) if self.gap <= BRIDGED && is_near(before) => Some(before),
            _ => None,
        };
        if let Some(before) = before {
            // 2^21 mdeg/s for 1,024 ms, 2^29, and as much before.
            let travel = per_period((now + before) / 2) * self.gap;
            self.expected = (self.expected + travel).clamp(-FURTHEST, FURTHEST);
            self.last = LastRate::Settled(now);
        } else {
            self.unknown = MOST_PERIODS.min(self.unknown + self.gap);
            self.last = LastRate::Unsettled(now);
        }
        self.gap = 0;
        before.map(|before| now - before)
    }

    /// A control period without a scan, between two scans. The rate counts as unchanged until the
    /// next one; returns that change, if the rate is known.
    pub fn hold(&mut self, missed: u8) -> Option<i32> {
        self.pass(missed);
        matches!(self.last, LastRate::Settled(_)).then_some(0)
    }

    fn pass(&mut self, missed: u8) {
        let periods = i32::from(missed) + 1;
        self.periods = MOST_PERIODS.min(self.periods + periods);
        self.gap = LONGEST.min(self.gap + periods);
    }

    /// The expected travel with that of the control periods since the last scan.
    pub fn expected_now(&self) -> i32 {
        match self.last {
            LastRate::Settled(rate) if HOLDS => self.expected + per_period(rate) * self.gap,
            _ => self.expected,
        }
    }

    /// Control periods whose travel is not known, or not yet.
    pub fn blind_periods(&self) -> i32 {
        match self.last {
            LastRate::Settled(_) if HOLDS => self.periods.min(self.unknown),
            _ => self.periods.min(self.unknown + self.gap),
        }
    }

    /// Whether the travel may be known with the next back-EMF.
    pub fn is_in_short_gap(&self) -> bool {
        (1..=BRIDGED).contains(&self.gap)
    }

    /// Whether the travel is known.
    pub fn is_known(&self) -> bool {
        self.unknown + self.gap == 0
    }

    /// The next comparison begins.
    pub fn begin(&mut self) {
        (self.expected, self.periods, self.unknown) = (0, 0, 0);
    }

    /// The comparison begins anew. What the motor has turned in a gap before is not of the encoder's
    /// travel from now on.
    pub fn restarted(self) -> Self {
        Self {
            last: match self.gap {
                0 => self.last,
                _ => LastRate::Unknown,
            },
            ..Self::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Behind two back-EMFs of this rate.
    fn settled(rate: i32) -> MotorTravel {
        let mut travel = MotorTravel::default();
        for _ in 0..2 {
            travel.advance(Some(rate), 0);
        }
        travel
    }

    /// Whether the travel of a control period with this rate is known.
    fn is_known(travel: &mut MotorTravel, rate: Option<i32>, missed: u8) -> bool {
        travel.begin();
        travel.advance(rate, missed);
        travel.is_known()
    }

    #[test]
    fn after_a_restart_in_a_gap_the_travel_is_known_behind_two_rates_that_agree() {
        let mut travel = settled(100_000);
        travel.advance(None, 0);
        let mut travel = travel.restarted();
        let known = [100_000, 20_000, 10_000].map(|rate| is_known(&mut travel, Some(rate), 0));
        assert_eq!(known, [false, false, true]);
        assert_eq!(travel.expected, 15_000);
    }

    #[test]
    fn control_periods_that_did_not_run_are_bridged_but_behind_a_gap() {
        let mut travel = settled(0);
        assert!(is_known(&mut travel, Some(0), u8::MAX));
        assert!(!is_known(&mut travel, None, 0));
        assert!(!is_known(&mut travel, Some(0), u8::MAX));
    }
}
