//! The PWM timer of the board: from a duty to the compare value that the timer takes.
//!
//! At 1 kHz the timer resolves 1/560 %, at 20 kHz 1/84 %. The remainder of each rounding is added
//! to the next duty (first-order noise shaping), so that the mean duty is exact and the shaft does
//! not creep away from where a loop without quantisation would hold it.
//!
//! The cascade decides duties, without counts. The firmware takes the type of its outputs from
//! here, the simulations the duty that a compare value makes, and the model of the bridge the
//! instants of a period: the sequences of compare values are equal to the bit.

use super::units::Percent;
use crate::time::{PWM_PERIODS_PER_UPDATE, PWM_RATE_HZ};

/// Clock of the timer's peripheral, Hz.
pub const TIMER_CLOCK_HZ: u32 = 168_000_000;

/// Divider in front of the counter: the least with which a PWM period fits the 16 bits of the
/// timer, 3 at 1 kHz and 1 at 20 kHz.
pub const TIMER_DIVIDER: u32 = (TIMER_CLOCK_HZ / PWM_RATE_HZ).div_ceil(1 << 16);

/// Counts in one microsecond.
pub const COUNTS_PER_US: u32 = TIMER_CLOCK_HZ / TIMER_DIVIDER / 1_000_000;

/// Counts in one PWM period: 56,000 at 1 kHz, 8,400 at 20 kHz.
pub const PWM_COUNTS: i32 = (TIMER_CLOCK_HZ / TIMER_DIVIDER / PWM_RATE_HZ) as i32;

const _: () = assert!(
    PWM_COUNTS <= 1 << 16 && PWM_COUNTS % 100 == 0,
    "the period fits the timer and a percent is a whole number of counts"
);

/// Counts in one update period.
pub const UPDATE_COUNTS: u32 = PWM_COUNTS as u32 * PWM_PERIODS_PER_UPDATE;

/// Counts for one percent.
const COUNTS_PER_PERCENT: i64 = PWM_COUNTS as i64 / 100;

/// Length of the coast window at the end of the last update period of a control period, us.
///
/// After the switches open, the diodes carry the winding's current until it is zero: 77 us from a
/// stall at full duty, and up to 122 us from the currents of a reversal below 1 A. The legs then
/// settle with 6.7 us (20 kohm parallel to 10 kohm, 1 nF), within half a code after eight time
/// constants: 122 us + 53 us = 175 us to the sample of the legs. After a greater current a leg is
/// still at a rail, and the sample is refused.
///
/// With several PWM periods in an update period it starts 5 us before a PWM edge: a compare value
/// at the edge itself would not match.
const WINDOW_US: u32 = if PWM_PERIODS_PER_UPDATE == 1 {
    200
} else {
    205
};

/// Time from the sample of the legs to the end of the window, us: the scan takes 13.7 us.
const SCAN_US: u32 = 25;

/// Counts from the start of the update period to the coast window: all switches open.
pub const WINDOW_START: u32 = UPDATE_COUNTS - WINDOW_US * COUNTS_PER_US;

/// Counts from the start of the update period to the scan of the legs.
pub const BACK_EMF_INSTANT: u32 = UPDATE_COUNTS - SCAN_US * COUNTS_PER_US;

/// Earliest count at which the conversion of the current starts: 10 us after the edge, later than
/// the interrupt that enables it.
const EARLIEST_CURRENT: u32 = 10 * COUNTS_PER_US;

/// Count for on times whose middle is earlier: at 20 kHz the middle of the period, 5 us or more
/// behind the end of the on time, since these are up to 40 % of it.
const OF_SHORT_ON_TIMES: u32 = if PWM_PERIODS_PER_UPDATE == 1 {
    EARLIEST_CURRENT
} else {
    PWM_COUNTS as u32 / 2
};

/// Latest count for it: current and supply take 7.8 us and must end before the window starts.
const LATEST_CURRENT: u32 = WINDOW_START - 10 * COUNTS_PER_US;

const _: () = assert!(
    LATEST_CURRENT < PWM_COUNTS as u32,
    "the current is sampled in the first PWM period"
);

/// Time from the compare event to the instant whose current is converted, in cycles of the timer's
/// clock: 50 cycles of the interrupt, 448 of the converter's sampling phase (56 cycles of 21 MHz),
/// less the delay of the amplifier, 67 cycles (400 kHz: 0.4 us).
pub const APERTURE_CYCLES: u32 = 50 + 448 - 67;

/// Count at which the current is sampled: the middle of the on time of the first PWM period of an
/// update period. Where that is too early it is sampled during the slow decay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CurrentInstant(u32);

impl CurrentInstant {
    /// The instant for an on time, counts.
    ///
    /// ```
    /// use model_core::control::pwm_timer::{COUNTS_PER_US, CurrentInstant};
    /// assert_eq!(CurrentInstant::of_on_time(20_000).count(), 10_000);
    /// assert_eq!(CurrentInstant::of_on_time(0).count(), 10 * COUNTS_PER_US);
    /// ```
    pub const fn of_on_time(counts: u32) -> Self {
        match counts / 2 {
            middle if middle < EARLIEST_CURRENT => Self(OF_SHORT_ON_TIMES),
            middle if middle > LATEST_CURRENT => Self(LATEST_CURRENT),
            middle => Self(middle),
        }
    }

    /// The instant of a count of the timer; counts outside the range of instants are limited to it.
    pub const fn of_count(count: u32) -> Self {
        Self::of_on_time(count.saturating_mul(2))
    }

    /// The count of the timer.
    pub const fn count(self) -> u32 {
        self.0
    }

    /// The instant whose current is converted, in cycles of the timer's clock after the edge.
    pub const fn sampled_cycles(self) -> u32 {
        self.0 * TIMER_DIVIDER + APERTURE_CYCLES
    }
}

/// On time of the bridge in counts of the timer, with the sign of the voltage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PwmCompare(i32);

impl PwmCompare {
    /// -[`PWM_COUNTS`] to [`PWM_COUNTS`].
    pub const fn get(self) -> i32 {
        self.0
    }

    /// The duty of this compare value, %.
    pub fn duty_pct(self) -> f64 {
        self.0 as f64 / COUNTS_PER_PERCENT as f64
    }
}

/// Rounds duties to compare values and carries the remainder over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Modulator {
    /// Remainder of the last compare value, in 2^-32 counts: half a count at most.
    remainder: i64,
}

impl Modulator {
    /// The compare value for the next duty, which is within +-100 %: no duty limit is wider.
    ///
    /// ```
    /// use model_core::control::{pwm_timer::Modulator, units::percent};
    /// let mut modulator = Modulator::default();
    /// // 0.1 % are 56 counts, 0.0005 % are 0.28.
    /// assert_eq!([0; 4].map(|_| modulator.next(percent(0.1005)).get()), [56, 57, 56, 56]);
    /// assert_eq!(modulator.next(percent(-100.0)).get(), -56_000);
    /// ```
    pub fn next(&mut self, duty: Percent) -> PwmCompare {
        // |duty| <= 100 * 2^32 and 560 < 2^10: within 2^49, remainder and rounding included.
        let exact = duty.to_bits() * COUNTS_PER_PERCENT + self.remainder;
        let counts = (exact + (1 << 31)) >> 32;
        // From -2^31 to 2^31 - 1: a full duty rounds to 56,000 again.
        self.remainder = exact - (counts << 32);
        PwmCompare(counts as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::units::percent;

    #[test]
    fn the_mean_of_compare_values_is_the_duty() {
        let mut modulator = Modulator::default();
        let counts: i32 = (0..1_000)
            .map(|_| modulator.next(percent(-0.1005)).get())
            .sum();
        // 0.1005 % of the period a thousand times, to a count.
        let exact = -0.001_005 * f64::from(PWM_COUNTS) * 1_000.0;
        assert!((f64::from(counts) - exact).abs() <= 1.0, "{counts}");
        assert_eq!(modulator.next(percent(100.0)).get(), PWM_COUNTS);
        assert_eq!(PwmCompare(-PWM_COUNTS).duty_pct(), -100.0);
    }

    #[test]
    fn a_compare_value_is_the_nearest_to_its_duty() {
        // 560 counts a percent: 56.28 and 56.73.
        for (duty_pct, counts) in [(0.1005, 56), (0.1013, 57), (-0.1005, -56), (-0.1013, -57)] {
            assert_eq!(Modulator::default().next(percent(duty_pct)).get(), counts);
        }
    }

    #[test]
    fn the_current_is_sampled_in_the_middle_within_its_limits() {
        let count = |on_time| CurrentInstant::of_on_time(on_time).count();
        assert_eq!(count(0), EARLIEST_CURRENT);
        assert_eq!(count(2 * EARLIEST_CURRENT + 2), EARLIEST_CURRENT + 1);
        assert_eq!(count(2 * LATEST_CURRENT - 2), LATEST_CURRENT - 1);
        assert_eq!(count(u32::MAX), LATEST_CURRENT);
        // Ten microseconds before all switches open.
        assert_eq!(count(u32::MAX), WINDOW_START - 560);
    }
}
