//! From encoder counts to the angle of the shaft: direction, zero, turns.

use core::num::NonZeroU16;

use super::{
    encoder_word::{COUNTS_PER_TURN, EncoderCount},
    units::{ANGLE_END, Angle, hold_whole},
};

/// One count in steps of [`Angle`]: 45/512 deg.
pub const COUNT_STEPS: i64 = 45 << (32 - 9);

/// How the encoder sits on the shaft.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mounting {
    /// The count that is called zero.
    pub zero: EncoderCount,
    /// Whether counts fall where the duty is positive.
    pub reversed: bool,
}

impl Mounting {
    /// The angle that is called zero, -180 deg to 180 deg.
    pub fn zero_deg(self) -> Angle {
        // |counts| <= 2^11 and COUNT_STEPS < 2^29.
        Angle::from_bits(i64::from(wrap(i32::from(self.zero.get()))) * COUNT_STEPS)
    }

    /// Counts from zero, -2048 to 2047, in the sense of the duty.
    const fn relative(self, count: EncoderCount) -> i32 {
        self.between(self.zero, count)
    }

    /// Counts from one to the other, -2048 to 2047, in the sense of the duty.
    const fn between(self, from: EncoderCount, to: EncoderCount) -> i32 {
        let counts = to.get() as i32 - from.get() as i32;
        wrap(if self.reversed { -counts } else { counts })
    }
}

/// The difference of counts that is nearest to zero, -2048 to 2047.
const fn wrap(counts: i32) -> i32 {
    (counts + COUNTS_PER_TURN / 2).rem_euclid(COUNTS_PER_TURN) - COUNTS_PER_TURN / 2
}

/// What one valid reading says of the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Motion {
    /// Counts travelled since the last valid reading, -2048 to 2047; 0 at the first.
    pub counts: i32,
    /// Control periods since then.
    pub periods: NonZeroU16,
}

/// Follows the shaft over turns and over samples that were lost.
///
/// The first reading lies within half a turn of zero. From then on the shaft may turn by less
/// than half a turn between two valid readings: 45,000 deg/s without a loss.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ShaftAngle {
    /// Counts from zero, over all turns. Two billion counts are 70 minutes at 45,000 deg/s; from
    /// there on they stay.
    counts: i32,
    /// The last valid reading.
    last: Option<EncoderCount>,
    /// Samples lost since then.
    lost: u8,
}

impl ShaftAngle {
    /// Takes a valid reading.
    pub fn reading(&mut self, mounting: Mounting, count: EncoderCount) -> Motion {
        let travelled = match self.last {
            None => {
                self.counts = mounting.relative(count);
                0
            }
            Some(last) => mounting.between(last, count),
        };
        self.counts = self.counts.saturating_add(travelled);
        self.last = Some(count);
        // 256 at the most, since `lost` is a u8.
        let periods = NonZeroU16::MIN.saturating_add(self.lost.into());
        self.lost = 0;
        Motion {
            counts: travelled,
            periods,
        }
    }

    /// Takes note of a sample without a valid reading.
    pub fn lost(&mut self) {
        self.lost = self.lost.saturating_add(1);
    }

    /// The angle, held within [`ANGLE_END`].
    #[inline(always)]
    pub fn angle(&self) -> Angle {
        // |counts| <= 2^31 and COUNT_STEPS < 2^29: the product lies within 2^60.
        let mut angle = Angle::from_bits(self.counts as i64 * COUNT_STEPS);
        hold_whole(&mut angle, ANGLE_END.to_num());
        angle
    }

    /// Whether there was a valid reading.
    pub fn is_known(&self) -> bool {
        self.last.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_through_zero_is_the_short_one() {
        let mounting = Mounting {
            zero: EncoderCount::new(0),
            reversed: false,
        };
        let mut shaft = ShaftAngle::default();
        shaft.reading(mounting, EncoderCount::new(4095));
        let motion = shaft.reading(mounting, EncoderCount::new(1));
        let (counts, periods) = (2, NonZeroU16::MIN);
        assert_eq!(motion, Motion { counts, periods });
        assert_eq!(shaft.angle(), 45.0 / 512.0);
    }
}
