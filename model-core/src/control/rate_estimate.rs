//! The angular rate, from differences of the encoder through a first-order filter.
//!
//! `rate += alpha (counts * 45/512 deg / (periods * T) - rate)` in each control period `T`.

use super::{
    arithmetic::Gain,
    encoder_word::{COUNT_DEG, COUNTS_PER_TURN},
    position_loop::RATE_END,
    shaft_tracker::Motion,
    units::{Rate, limit_between},
};
use crate::time::CONTROL_RATE_HZ;

/// One count a control period in units of 2^-9 deg/s, in which it is whole.
const COUNT_RATE: i32 = (COUNT_DEG * 512.0) as i32 * CONTROL_RATE_HZ as i32;

/// Fractional bits of a raw rate: the most with which half a turn in one period fits 31 bits. At
/// 250 Hz that are 15.
const FRACTION_BITS: u32 = 9 + (i32::MAX / (COUNT_RATE * HALF_TURN)).ilog2();

/// Counts in half a turn.
const HALF_TURN: i32 = COUNTS_PER_TURN / 2;

/// One count a control period, in steps of a raw rate.
const COUNT_RATE_STEPS: i32 = COUNT_RATE << (FRACTION_BITS - 9);

/// Weight of a new difference in the estimate.
pub type FilterShare<const VECTOR: bool = false> = Gain<Rate, Rate, VECTOR>;

/// Weight where another sensor shows the changes of the rate: 80 ms of time constant.
pub(super) const SLOW_FILTER: FilterShare = FilterShare::new(12.5 / CONTROL_RATE_HZ as f64);

/// The filtered rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RateEstimate(pub(super) Rate);

impl RateEstimate {
    /// Updates the estimate by the motion up to one valid count.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub fn update<const VECTOR: bool>(&mut self, share: FilterShare<VECTOR>, motion: Motion) {
        // |counts| <= 2^11: the product fits 31 bits by the choice of FRACTION_BITS; at 250 Hz it is
        // within 45,000 deg/s. A single period divides by one, so it is exact.
        let travelled = motion.counts * COUNT_RATE_STEPS;
        let steps = match i32::from(motion.periods.get()) {
            // A PC divides in ten to twenty cycles, the board in as many as a comparison takes.
            1 if cfg!(target_pointer_width = "64") => travelled,
            periods => travelled / periods,
        };
        let raw = Rate::from_bits((steps as i64) << (32 - FRACTION_BITS));
        // Both lie within 45,000 deg/s (the estimate is a mean of raw rates, as 0 < share <= 1),
        // so the difference lies within 2^17 and the product within 2^17.
        self.0 += share.times(raw - self.0);
    }

    /// The rate has changed by this much, by another sensor.
    pub fn change(&mut self, change: Rate) {
        // Both within 2^17.
        let mut rate = self.0 + change;
        let _ = limit_between(&mut rate, RATE_END, RATE_END);
        self.0 = rate;
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
        estimate.update(<FilterShare>::new(0.5), Motion { counts, periods });
        // 512 counts are 45 deg a period.
        assert_eq!(estimate.rate(), rate(22.5 * f64::from(CONTROL_RATE_HZ)));
    }
}
