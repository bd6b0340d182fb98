//! States of the bridge in a PWM period, and the terminal voltages that they cause.

use crate::control::pwm_timer::{CurrentInstant, TIMER_CLOCK_HZ, TIMER_DIVIDER};
use crate::time::PWM_RATE_HZ;

/// Cycles of the timer's clock, 168 MHz, in a PWM period: 168,000 at 1 kHz, 8,400 at 20 kHz.
pub const PERIOD_CYCLES: u32 = TIMER_CLOCK_HZ / PWM_RATE_HZ;

/// Cycles in a count of the timer.
const CYCLES_PER_COUNT: u32 = TIMER_DIVIDER;

/// Dead time: neither switch of a leg conducts for 1 us.
const DEAD_CYCLES: u32 = 168;

/// On time of a full period less the dead time. A full period has no edge and loses nothing.
const FULL_CYCLES: u32 = PERIOD_CYCLES - DEAD_CYCLES;

/// State of the bridge over a PWM period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bridge {
    /// All switches open.
    Coast,
    /// Both low sides closed.
    Brake,
    /// The high side of one leg closed from the start of the period, the low side of the other leg
    /// closed throughout.
    Driven {
        /// Whether leg A is switched: a positive voltage.
        is_positive: bool,
        /// On time of its high side, cycles of 168 MHz; [`PERIOD_CYCLES`] is the whole period.
        on_cycles: u32,
    },
}

/// State of the switches in a part of a slot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Switched {
    /// All switches open.
    Open,
    /// Both low sides closed.
    Shorted,
    /// The high side of the leg that drives with this sign closed.
    Supply(f64),
    /// Both switches of the leg that drives with this sign open.
    Dead(f64),
}

/// Connection of the winding that switches and diodes make.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Connection {
    /// None, or to the supply through two diodes while the current flows.
    Open,
    /// Both terminals to ground.
    Shorted,
    /// To the supply with this sign.
    Supply(f64),
}

impl Switched {
    /// The connection of a winding with this current. In a dead time a diode of the leg carries it,
    /// to the supply if it flows against the sign, else from ground; it does not change its sign
    /// within that microsecond.
    pub fn connection(self, current_a: f64) -> Connection {
        match self {
            Self::Open => Connection::Open,
            Self::Supply(sign) => Connection::Supply(sign),
            Self::Dead(sign) if sign * current_a < 0.0 => Connection::Supply(sign),
            Self::Shorted | Self::Dead(_) => Connection::Shorted,
        }
    }
}

impl Bridge {
    /// The state for a compare value of the board, counts of the timer. The dead time shortens
    /// the on time, except in a full period; an on time that is not longer than the dead time
    /// brakes.
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
        Self::after_dead_time(compare > 0, cycles.saturating_sub(DEAD_CYCLES))
    }

    /// The state for an on time from which the dead time has been subtracted. The timer subtracts
    /// it from a full period as well.
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

    /// The instant at which the board samples the current in a period with this state.
    pub fn current_instant(self) -> CurrentInstant {
        let cycles = match self {
            Self::Coast | Self::Brake => 0,
            Self::Driven {
                on_cycles: PERIOD_CYCLES,
                ..
            } => PERIOD_CYCLES,
            Self::Driven { on_cycles, .. } => on_cycles + DEAD_CYCLES,
        };
        CurrentInstant::of_on_time(cycles / CYCLES_PER_COUNT)
    }

    /// The switch states between two cycles of an update period, with their lengths in cycles, in
    /// the order of the PWM periods.
    pub(super) fn between(self, from: u32, until: u32) -> impl Iterator<Item = (Switched, u32)> {
        let first = from / PERIOD_CYCLES;
        let end = until.div_ceil(PERIOD_CYCLES).max(first + 1);
        (first..end).flat_map(move |period| {
            let start = period * PERIOD_CYCLES;
            let until = (until - start).min(PERIOD_CYCLES);
            self.in_pwm_period(from.saturating_sub(start), until)
        })
    }

    /// The switch states between two cycles of a PWM period, with their lengths in cycles. The high
    /// side closes a dead time after the edge, and the low side a dead time after it has opened.
    fn in_pwm_period(self, from: u32, until: u32) -> [(Switched, u32); 4] {
        let (is_positive, on_cycles) = match self {
            Self::Coast => return [(Switched::Open, until - from), NONE, NONE, NONE],
            Self::Brake => return [(Switched::Shorted, until - from), NONE, NONE, NONE],
            Self::Driven {
                is_positive,
                on_cycles,
            } => (is_positive, on_cycles),
        };
        let sign = if is_positive { 1.0 } else { -1.0 };
        let is_full = on_cycles == PERIOD_CYCLES;
        let dead = if is_full { 0 } else { DEAD_CYCLES };
        let rise = dead.clamp(from, until);
        let fall = (dead + on_cycles).clamp(from, until);
        let low = (dead + on_cycles + dead).clamp(from, until);
        [
            (Switched::Dead(sign), rise - from),
            (Switched::Supply(sign), fall - rise),
            (Switched::Dead(sign), low - fall),
            (Switched::Shorted, until - low),
        ]
    }
}

/// No time.
const NONE: (Switched, u32) = (Switched::Shorted, 0);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_on_time_lies_between_two_dead_times() {
        let bridge = Bridge::driven(28_000);
        let (dead, on) = (Switched::Dead(1.0), Switched::Supply(1.0));
        let off = Switched::Shorted;
        let head = [(dead, 168), (on, 83_832), (dead, 168), (off, 50_232)];
        assert_eq!(bridge.in_pwm_period(0, 134_400), head);
        let part = [(dead, 0), (on, 4_000), (dead, 168), (off, 832)];
        assert_eq!(bridge.in_pwm_period(80_000, 85_000), part);
    }

    #[test]
    fn a_full_period_has_no_off_time() {
        for compare in [56_000_i32, -56_000] {
            let sign = f64::from(compare.signum());
            let parts = Bridge::driven(compare).in_pwm_period(0, PERIOD_CYCLES);
            assert_eq!(parts[1], (Switched::Supply(sign), PERIOD_CYCLES));
            assert_eq!(
                parts.map(|(_, cycles)| cycles).iter().sum::<u32>(),
                PERIOD_CYCLES
            );
        }
    }

    #[test]
    fn brake_and_coast_drive_nothing() {
        assert_eq!(
            Bridge::Brake.in_pwm_period(0, 10)[0],
            (Switched::Shorted, 10)
        );
        assert_eq!(Bridge::Coast.in_pwm_period(0, 10)[0], (Switched::Open, 10));
        assert_eq!(Bridge::driven(0), Bridge::Brake);
    }

    #[test]
    fn the_current_is_sampled_in_the_middle_of_the_commanded_on_time() {
        for compare in [
            0_i32, 56, 57, 1120, 20_001, -40_000, 44_000, -55_999, 56_000,
        ] {
            let expected = CurrentInstant::of_on_time(i32::unsigned_abs(compare));
            assert_eq!(
                Bridge::driven(compare).current_instant(),
                expected,
                "{compare}"
            );
        }
    }
}
