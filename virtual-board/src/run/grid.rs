//! Instants at which the run stops for the plant: ahead of the end of each slot of an update
//! period.

use model_core::control::pwm_timer::CurrentInstant;
use model_core::time::{PWM_PERIODS_PER_UPDATE, UPDATE_PERIOD_NS};

use crate::plant::Slot;

/// Time before the end of a slot at which the state of the bridge is read, ns. The converter
/// samples the current 2.6 us after the compare event that starts it.
const AHEAD_NS: u64 = 5_000;

/// Length of an update period, ns.
const PERIOD_NS: u64 = UPDATE_PERIOD_NS;

/// Length of a PWM period, ns.
pub(super) const PWM_PERIOD_NS: u64 = PERIOD_NS / PWM_PERIODS_PER_UPDATE as u64;

/// Tolerance for the instant of an edge: more than an instruction takes, ns.
const SLACK_NS: u64 = 1_000;

/// The grid, locked to the update periods of the timer.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    period_ns: u64,
    slot: Slot,
    /// The instant at which the present period samples the current.
    pub current: CurrentInstant,
    /// The timer has started.
    pub is_locked: bool,
    /// The timer has not been seen stopped since the grid was aligned with it.
    is_aligned: bool,
}

impl Grid {
    pub fn new() -> Self {
        Self {
            period_ns: 0,
            slot: Slot::Current,
            current: CurrentInstant::of_on_time(0),
            is_locked: false,
            is_aligned: false,
        }
    }

    /// The next stop, ns, and the slot that ends shortly after it.
    pub fn next(&self) -> (u64, Slot) {
        (self.end_ns() - AHEAD_NS, self.slot)
    }

    /// The nominal end of the present slot, ns.
    pub fn end_ns(&self) -> u64 {
        self.period_ns + self.slot.until_ns(self.current)
    }

    /// Advances to the next slot; after the last of a period, to the first of the period that
    /// samples the current at `next_current`.
    pub fn pass(&mut self, next_current: CurrentInstant) {
        if self.slot == Slot::Edge {
            self.period_ns += PERIOD_NS;
            self.current = next_current;
        }
        self.slot = self.slot.next();
    }

    /// The timer is stopped: its next period is the first of an update period.
    pub fn lose(&mut self) {
        self.is_aligned = false;
    }

    /// Aligns the grid with the timer, a PWM period of which began at this instant, ns: the first
    /// one of an update period if the timer has just started. Returns whether the grid moved; the
    /// present slot is then the first of the period.
    pub fn follow(&mut self, edge_ns: u64) -> bool {
        let repeats_ns = if self.is_aligned {
            PWM_PERIOD_NS
        } else {
            PERIOD_NS
        };
        self.is_aligned = true;
        let apart_ns = (edge_ns % repeats_ns).abs_diff(self.period_ns % repeats_ns);
        let apart_ns = apart_ns.min(repeats_ns - apart_ns);
        if self.is_locked && apart_ns < SLACK_NS {
            return false;
        }
        self.is_locked = true;
        self.period_ns = edge_ns;
        self.slot = Slot::Current;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALF: CurrentInstant = CurrentInstant::of_on_time(28_000);

    #[test]
    fn the_slots_of_a_period_come_in_their_order() {
        let mut grid = Grid::new();
        assert!(grid.follow(3_000_000));
        let mut stops = Vec::new();
        for _ in 0..5 {
            stops.push(grid.next().0);
            grid.pass(HALF);
        }
        // The current is sampled at 10 us and 431 cycles of 168 MHz, then at 250 us and 431 cycles.
        let expected = [3_007_565, 3_795_000, 3_970_000, 3_995_000, 4_247_565];
        assert_eq!(stops, expected);
    }

    #[test]
    fn an_edge_at_its_expected_instant_does_not_move_the_grid() {
        let mut grid = Grid::new();
        grid.follow(3_000_000);
        grid.pass(HALF);
        assert!(!grid.follow(9_000_012));
        assert!(!grid.follow(2_999_990));
        assert_eq!(grid.next().1, Slot::Window);
        assert!(grid.follow(9_400_000));
        assert_eq!(grid.next(), (9_407_565, Slot::Current));
    }
}
