//! From a duty to the compare value of the PWM timer.
//!
//! The timer resolves 1/560 %. What rounding takes from one period is added to the next
//! (first-order noise shaping), so that the mean duty is exact and the shaft does not creep away
//! from where the loop in exact numbers would have it.

use super::units::Percent;

/// Counts in one PWM period: 1 kHz from a timer clock of 56 MHz (168 MHz divided by three), the
/// finest that fits the 16 bits of the timer.
pub const PWM_COUNTS: i32 = 56_000;

/// Counts for one percent.
const COUNTS_PER_PERCENT: i64 = PWM_COUNTS as i64 / 100;

/// On time of the bridge in counts of the timer, with the sign of the voltage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Compare(i32);

impl Compare {
    /// -56,000 to 56,000.
    pub const fn get(self) -> i32 {
        self.0
    }

    /// The duty that the timer makes of it, %.
    pub fn duty_pct(self) -> f64 {
        self.0 as f64 / COUNTS_PER_PERCENT as f64
    }
}

/// Rounds duties to compare values and remembers what that took away.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Modulator {
    /// What the last compare value fell short by, in 2^-32 counts: half a count at most.
    remainder: i64,
}

impl Modulator {
    /// The compare value for the next duty, which is within +-100 %: no duty limit is wider.
    ///
    /// ```
    /// use model_core::control::{compare::Modulator, units::percent};
    /// let mut modulator = Modulator::default();
    /// // 0.1 % are 56 counts, 0.0005 % are 0.28.
    /// assert_eq!([0; 4].map(|_| modulator.next(percent(0.1005)).get()), [56, 57, 56, 56]);
    /// assert_eq!(modulator.next(percent(-100.0)).get(), -56_000);
    /// ```
    pub fn next(&mut self, duty: Percent) -> Compare {
        // |duty| <= 100 * 2^32 and 560 < 2^10: within 2^49, remainder and rounding included.
        let wanted = duty.to_bits() * COUNTS_PER_PERCENT + self.remainder;
        let counts = (wanted + (1 << 31)) >> 32;
        // From -2^31 to 2^31 - 1, so that a full duty stays one: it rounds to 56,000 again.
        self.remainder = wanted - (counts << 32);
        Compare(counts as i32)
    }
}
