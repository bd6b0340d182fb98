//! The pieces of an update period between which the board samples.

use crate::control::pwm_timer::{
    BACK_EMF_INSTANT, CurrentInstant, TIMER_CLOCK_HZ, TIMER_DIVIDER, UPDATE_COUNTS, WINDOW_START,
};
use crate::time::UPDATE_PERIOD_NS;

/// Cycles of the timer's clock in an update period.
const UPDATE_CYCLES: u32 = UPDATE_COUNTS * TIMER_DIVIDER;

/// A piece of an update period, named by the event at its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slot {
    /// From the edge to the instant at which the current is sampled.
    Current,
    /// To the count at which the coast window starts, if there is one.
    Window,
    /// To the instant at which the legs are sampled.
    Legs,
    /// To the next edge.
    Edge,
}

impl Slot {
    /// All slots of a period, in order.
    pub const ALL: [Self; 4] = [Self::Current, Self::Window, Self::Legs, Self::Edge];

    /// The slot after this one.
    pub const fn next(self) -> Self {
        match self {
            Self::Current => Self::Window,
            Self::Window => Self::Legs,
            Self::Legs => Self::Edge,
            Self::Edge => Self::Current,
        }
    }

    /// Its start and end in cycles of the timer's clock, in a period that samples the current at
    /// this instant.
    pub(super) const fn cycles(self, current: CurrentInstant) -> (u32, u32) {
        let window = WINDOW_START * TIMER_DIVIDER;
        let legs = BACK_EMF_INSTANT * TIMER_DIVIDER;
        match self {
            Self::Current => (0, current.sampled_cycles()),
            Self::Window => (current.sampled_cycles(), window),
            Self::Legs => (window, legs),
            Self::Edge => (legs, UPDATE_CYCLES),
        }
    }

    /// Its end in the period, ns, rounded down.
    pub const fn until_ns(self, current: CurrentInstant) -> u64 {
        let (_, until) = self.cycles(current);
        nanoseconds(until)
    }

    /// Its length, ns: the difference of its ends in whole ns.
    pub const fn length_ns(self, current: CurrentInstant) -> u64 {
        let (from, _) = self.cycles(current);
        self.until_ns(current) - nanoseconds(from)
    }
}

/// The instant of a cycle, ns, rounded down.
const fn nanoseconds(cycles: u32) -> u64 {
    cycles as u64 * UPDATE_PERIOD_NS / UPDATE_CYCLES as u64
}

/// The length of so many cycles of the timer's clock, s.
pub(super) fn seconds(cycles: u32) -> f64 {
    f64::from(cycles) / f64::from(TIMER_CLOCK_HZ)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slots_of_a_period_are_contiguous_at_any_on_time() {
        for on_counts in (0..=56_000).step_by(7) {
            let current = CurrentInstant::of_on_time(on_counts);
            let mut end = 0;
            for slot in Slot::ALL {
                let (from, until) = slot.cycles(current);
                assert_eq!(from, end);
                assert!(until > from, "{slot:?} at {on_counts}");
                end = until;
            }
            assert_eq!(end, UPDATE_CYCLES);
        }
    }
}
