//! What the bridge does in a PWM period.

use crate::plant::pwm_timer::{TIMER_CLOCK_HZ, TIMER_DIVIDER};
use crate::time::{PWM_PERIOD_NS, PWM_RATE_HZ};

/// Cycles of the timer's clock, 168 MHz, in a PWM period: 168,000 at 1 kHz.
pub const PERIOD_CYCLES: u32 = TIMER_CLOCK_HZ / PWM_RATE_HZ;

/// Cycles in a count of the timer.
const CYCLES_PER_COUNT: u32 = TIMER_DIVIDER;

/// 1 us, during which neither switch of a leg conducts.
const DEAD_CYCLES: u32 = 168;

/// What the dead time leaves of a full period, which has no edge and loses nothing.
const FULL_CYCLES: u32 = PERIOD_CYCLES - DEAD_CYCLES;

/// State of the bridge, for as long as it stays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bridge {
    /// All switches open.
    Coast,
    /// Both low sides closed.
    Brake,
    /// One leg's high side closed from the period's start on, the other leg's low side all the
    /// time.
    Driven {
        /// Whether leg A is switched: a positive voltage.
        is_positive: bool,
        /// How long its high side conducts, cycles of 168 MHz; [`PERIOD_CYCLES`] is all the time.
        on_cycles: u32,
    },
}

impl Bridge {
    /// The state for a compare value of the board, -56,000 to 56,000 counts: the dead time goes off
    /// the on time, and a full period has none. What is no longer than the dead time brakes.
    ///
    /// ```
    /// use model_core::plant::board::Bridge;
    ///
    /// let bridge = Bridge::driven(-28_000);
    /// assert_eq!(bridge, Bridge::Driven { is_positive: false, on_cycles: 84_000 - 168 });
    /// assert_eq!(Bridge::driven(56), Bridge::Brake);
    /// ```
    pub fn driven(compare: i32) -> Self {
        let cycles = compare.unsigned_abs().saturating_mul(CYCLES_PER_COUNT);
        Self::of_cycles(compare > 0, cycles)
    }

    fn of_cycles(is_positive: bool, cycles: u32) -> Self {
        Self::after_dead_time(is_positive, cycles.saturating_sub(DEAD_CYCLES))
    }

    /// The state for a high side that conducts for so many cycles. The timer knows of no full
    /// period: it takes the dead time off that one as well.
    pub fn after_dead_time(is_positive: bool, cycles: u32) -> Self {
        match cycles {
            0 => Self::Brake,
            1..FULL_CYCLES => Self::Driven {
                is_positive,
                on_cycles: cycles,
            },
            _ => Self::Driven {
                is_positive,
                on_cycles: PERIOD_CYCLES,
            },
        }
    }

    /// Mean voltage between these instants of the period, as a share of the supply.
    pub(super) fn share(&self, from_ns: u64, until_ns: u64) -> f64 {
        let Self::Driven {
            is_positive,
            on_cycles,
        } = *self
        else {
            return 0.0;
        };
        let cycles = |ns: u64| ns * u64::from(PERIOD_CYCLES) / PWM_PERIOD_NS;
        let (from, until) = (cycles(from_ns), cycles(until_ns));
        let on = u64::from(on_cycles).min(until).saturating_sub(from);
        let share = on as f64 / (until - from).max(1) as f64;
        if is_positive { share } else { -share }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_on_time_lies_at_the_start_of_the_period() {
        let bridge = Bridge::driven(28_056);
        // 500 us of 900, and none of the rest.
        assert_eq!(bridge.share(0, 900_000), 5.0 / 9.0);
        assert_eq!(bridge.share(900_000, 1_000_000), 0.0);
        assert_eq!(bridge.share(0, 1_000_000), 0.5);
    }

    #[test]
    fn a_long_on_time_reaches_into_the_window_and_a_full_one_through_it() {
        let bridge = Bridge::driven(-(53_200 + 56));
        assert_eq!(bridge.share(0, 900_000), -1.0);
        assert_eq!(bridge.share(900_000, 1_000_000), -0.5);
        assert_eq!(Bridge::driven(56_000).share(900_000, 1_000_000), 1.0);
    }

    #[test]
    fn brake_and_coast_drive_nothing() {
        assert_eq!(Bridge::Brake.share(0, 900_000), 0.0);
        assert_eq!(Bridge::Coast.share(0, 900_000), 0.0);
        assert_eq!(Bridge::driven(0), Bridge::Brake);
    }
}
