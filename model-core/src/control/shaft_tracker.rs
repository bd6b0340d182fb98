//! From encoder counts to the angle of the shaft: direction, zero, turns, the encoder's error, and
//! periods without a valid count.
//!
//! This is the only place that follows the encoder. The protections ask it how far the shaft has
//! travelled and for how many periods, and the rate estimate divides one by the other.

use core::num::NonZeroU16;

use super::{
    encoder_correction::{Deviation, EncoderCorrection},
    encoder_word::{COUNT_DEG, COUNTS_PER_TURN, EncoderCount},
    units::{ANGLE_END, Angle, angle, limit_whole},
};

/// One count in steps of [`Angle`]: 45 * 2^23.
pub const COUNT_STEPS: i64 = angle(COUNT_DEG).to_bits();

/// How the encoder is mounted on the shaft.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mounting {
    /// The count at angle zero.
    pub zero: EncoderCount,
    /// Whether counts decrease with positive duty.
    pub reversed: bool,
}

impl Mounting {
    /// The encoder angle of zero, -180 deg to 180 deg.
    pub fn zero_deg(self) -> Angle {
        // |counts| <= 2^11 and COUNT_STEPS < 2^29.
        Angle::from_bits(i64::from(wrap(i32::from(self.zero.get()))) * COUNT_STEPS)
    }

    /// Counts from zero, -2048 to 2047, in the direction of positive duty.
    const fn relative(self, count: EncoderCount) -> i32 {
        self.between(self.zero, count)
    }

    /// Counts from one to the other, -2048 to 2047, in the direction of positive duty.
    const fn between(self, from: EncoderCount, to: EncoderCount) -> i32 {
        let counts = to.get() as i32 - from.get() as i32;
        wrap(if self.reversed { -counts } else { counts })
    }
}

/// The equivalent difference of counts that is nearest to zero, -2048 to 2047.
const fn wrap(counts: i32) -> i32 {
    ((counts + COUNTS_PER_TURN / 2) & (COUNTS_PER_TURN - 1)) - COUNTS_PER_TURN / 2
}

/// The motion between two valid counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Motion {
    /// Counts travelled, -2048 to 2047; 0 at the first valid count.
    pub counts: i32,
    /// Control periods between the two counts.
    pub periods: NonZeroU16,
}

/// Tracks the shaft over turns and over control periods without a valid count.
///
/// The first count lies within half a turn of zero. From then on the shaft may turn by less than
/// half a turn between two valid counts: at 45,000 deg/s in adjacent periods, at 180 deg/s over 250
/// missed ones. Beyond that whole turns are lost, and angle and rate are wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ShaftTracker {
    /// Counts from zero, over all turns; saturates after 70 minutes at 45,000 deg/s.
    pub(super) counts: i32,
    /// The last valid count.
    last: Option<EncoderCount>,
    /// Control periods without a valid count since then; saturates at 65,535.
    missed: u16,
    /// The encoder's deviation from the shaft at that count.
    #[cfg_attr(feature = "serde", serde(default))]
    deviation: Deviation,
}

impl ShaftTracker {
    /// The tracker after a valid count.
    #[inline(always)]
    pub(super) const fn at(counts: i32, last: EncoderCount) -> Self {
        Self {
            counts,
            last: Some(last),
            missed: 0,
            deviation: Deviation::NONE,
        }
    }

    /// Takes the valid count of this control period.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub fn update(&mut self, mounting: Mounting, count: EncoderCount) -> Motion {
        let travelled = match self.last {
            None => {
                self.counts = mounting.relative(count);
                0
            }
            Some(last) => mounting.between(last, count),
        };
        self.counts = self.counts.saturating_add(travelled);
        self.last = Some(count);
        let periods = NonZeroU16::MIN.saturating_add(self.missed);
        self.missed = 0;
        Motion {
            counts: travelled,
            periods,
        }
    }

    /// Subtracts the encoder's deviation at the last count from the angle. The motion between two
    /// counts is not corrected.
    pub fn correct(&mut self, correction: &EncoderCorrection) {
        self.deviation = correction.deviation(self.counts);
    }

    /// Counts control periods without a valid count.
    pub fn miss(&mut self, periods: u16) {
        self.missed = self.missed.saturating_add(periods);
    }

    /// Control periods without a valid count since the last one.
    pub fn missed(&self) -> u16 {
        self.missed
    }

    /// Counts from the last valid count to this one, the short way, -2048 to 2047 in the direction
    /// of the encoder; `None` before the first valid count.
    pub fn travel_to(&self, count: EncoderCount) -> Option<i32> {
        Some(wrap(i32::from(count.get()) - i32::from(self.last?.get())))
    }

    /// The angle less the encoder's deviation, limited to [`ANGLE_END`].
    #[inline(always)]
    pub fn angle(&self) -> Angle {
        // |counts| <= 2^31 and COUNT_STEPS < 2^29: the product lies within 2^60, the deviation
        // of 22.1 deg within 2^37.
        let mut angle = Angle::from_bits(self.counts as i64 * COUNT_STEPS) - self.deviation.angle();
        limit_whole(&mut angle, (ANGLE_END.to_bits() >> 32) as i32);
        angle
    }

    /// Whether there was a valid count.
    pub fn is_known(&self) -> bool {
        self.last.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOUNTING: Mounting = Mounting {
        zero: EncoderCount::new(0),
        reversed: false,
    };

    #[test]
    fn the_way_through_zero_is_the_short_one() {
        let mut shaft = ShaftTracker::default();
        shaft.update(MOUNTING, EncoderCount::new(4095));
        let motion = shaft.update(MOUNTING, EncoderCount::new(1));
        let (counts, periods) = (2, NonZeroU16::MIN);
        assert_eq!(motion, Motion { counts, periods });
        assert_eq!(shaft.angle(), angle(45.0 / 512.0));
    }

    #[test]
    fn a_constant_rate_is_found_after_any_number_of_missed_periods() {
        for missed in [0, 1, 8, 9, 50, 250] {
            // At most half a turn: 8 counts a period are 2008 counts after 250 missed ones.
            let travelled = 8 * (missed + 1);
            let mut shaft = ShaftTracker::default();
            shaft.update(MOUNTING, EncoderCount::new(3000));
            shaft.miss(missed);
            let count = EncoderCount::new(3000 + travelled);
            assert_eq!(shaft.travel_to(count), Some(i32::from(travelled)));
            let Motion { counts, periods } = shaft.update(MOUNTING, count);
            assert_eq!((counts, periods.get()), (i32::from(travelled), missed + 1));
            assert_eq!(shaft.missed(), 0);
        }
    }

    #[test]
    fn missed_periods_saturate() {
        let mut shaft = ShaftTracker::default();
        shaft.update(MOUNTING, EncoderCount::new(0));
        for _ in 0..300 {
            shaft.miss(255);
        }
        let motion = shaft.update(MOUNTING, EncoderCount::new(1));
        assert_eq!(motion.periods, NonZeroU16::MAX);
    }
}
