//! The angular rate, from differences of the encoder through a first-order filter.
//!
//! `rate += alpha (counts * 45/512 deg / (periods * 4 ms) - rate)`, every 4 ms.

use super::{arithmetic::Gain, shaft_tracker::Motion, units::Rate};

/// One count a control period, in steps of 2^-15 deg/s: 45/512 deg / 4 ms = 11,250/512 deg/s.
const COUNT_RATE_STEPS: i32 = 11_250 << (15 - 9);

/// Weight of a new difference in the estimate.
pub type FilterShare = Gain<Rate, Rate>;

/// The filtered rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RateEstimate(Rate);

impl RateEstimate {
    /// Updates the estimate by the motion up to one valid count.
    pub fn update(&mut self, share: FilterShare, motion: Motion) {
        // |counts| <= 2^11 and COUNT_RATE_STEPS = 720,000: within 1.48e9 < 2^31, which is
        // +-45,000 deg/s. A single period divides by one, so it is exact.
        let steps = motion.counts * COUNT_RATE_STEPS / i32::from(motion.periods.get());
        let raw = Rate::from_bits((steps as i64) << (32 - 15));
        // Both lie within 45,000 deg/s (the estimate is a mean of raw rates, as 0 < share <= 1),
        // so the difference lies within 2^17 and the product within 2^17.
        self.0 += share.times(raw - self.0);
    }

    /// The estimate, within +-45,000 deg/s.
    pub fn rate(&self) -> Rate {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::units::rate;

    #[test]
    fn half_of_a_difference_enters_with_a_share_of_a_half() {
        let mut estimate = RateEstimate::default();
        let (counts, periods) = (512, core::num::NonZeroU16::MIN);
        estimate.update(FilterShare::new(0.5), Motion { counts, periods });
        // 512 counts are 45 deg: 11,250 deg/s.
        assert_eq!(estimate.rate(), rate(5625.0));
    }
}
