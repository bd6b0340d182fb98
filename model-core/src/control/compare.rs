//! From a duty to the compare value of the PWM timer.

use super::{arithmetic::within, units::Percent};

/// Counts in one PWM period: 1 kHz from a timer clock of 56 MHz (168 MHz divided by three), the
/// finest that fits the 16 bits of the timer.
pub const PWM_COUNTS: i32 = 56_000;

/// Counts for one percent.
const COUNTS_PER_PERCENT: i64 = PWM_COUNTS as i64 / 100;

/// On time of the bridge in counts of the timer, with the sign of the voltage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Compare(i32);

impl Compare {
    /// The compare value nearest to a duty; beyond +-100 % the ends.
    ///
    /// ```
    /// use model_core::control::{compare::Compare, units::percent};
    /// assert_eq!(Compare::from_duty(percent(-50.0)).get(), -28_000);
    /// ```
    pub fn from_duty(duty: Percent) -> Self {
        const FULL: Percent = Percent::const_from_int(100);
        let duty = within(duty, -FULL, FULL);
        // |duty| <= 100 * 2^32 and 560 < 2^10: within 2^49.
        let counts = (duty.to_bits() * COUNTS_PER_PERCENT + (1 << 31)) >> 32;
        Self(counts as i32)
    }

    /// -56,000 to 56,000.
    pub const fn get(self) -> i32 {
        self.0
    }

    /// The duty that the timer makes of it, %.
    pub fn duty_pct(self) -> f64 {
        self.0 as f64 / COUNTS_PER_PERCENT as f64
    }
}
