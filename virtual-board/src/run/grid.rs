//! Instants at which the run stops for the plant: ahead of the end of each slot of a PWM period.

use model_core::control::pwm_timer::CurrentInstant;

use crate::plant::Slot;

/// Time before the end of a slot at which the state of the bridge is read, ns. The converter
/// samples the current 2.6 us after the compare event that starts it.
const AHEAD_NS: u64 = 5_000;

const PERIOD_NS: u64 = model_core::time::PWM_PERIOD_NS;

/// Tolerance for the instant of an edge: more than an instruction takes, ns.
const SLACK_NS: u64 = 1_000;

/// The grid, locked to the PWM periods of the timer.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    period_ns: u64,
    slot: Slot,
    /// The instant at which the present period samples the current.
    pub current: CurrentInstant,
    /// The timer has started.
    pub is_locked: bool,
}

impl Grid {
    pub fn new() -> Self {
        Self {
            period_ns: 0,
            slot: Slot::Current,
            current: CurrentInstant::of_on_time(0),
            is_locked: false,
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

    /// Aligns the grid with the timer, whose period began at this instant, ns. Returns whether the
    /// grid moved; the present slot is then the first of the period.
    pub fn follow(&mut self, edge_ns: u64) -> bool {
        let apart_ns = (edge_ns % PERIOD_NS).abs_diff(self.period_ns % PERIOD_NS);
        let apart_ns = apart_ns.min(PERIOD_NS - apart_ns);
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
