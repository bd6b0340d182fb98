//! Instants at which the run stops for the plant: 5 us before each boundary of its grid, and within
//! the back-EMF window.

use crate::plant::Slot;

/// The reason for a stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Point {
    /// The slot ends: the state of the bridge is read, and the plant advances.
    Boundary(Slot),
    /// Middle of the window: the legs are sampled again.
    Window,
}

/// Time before a boundary at which the state of the bridge is read, ns.
const AHEAD_NS: u64 = 5_000;

/// Instant within the period at which the legs are sampled, ns.
const WINDOW_MIDDLE_NS: u64 = (Slot::Tail.from_ns() + Slot::Tail.until_ns()) / 2;

const PERIOD_NS: u64 = Slot::Tail.until_ns();

/// Tolerance for the instant of an edge: more than an instruction takes, ns.
const SLACK_NS: u64 = 1_000;

/// The grid, locked to the PWM periods of the timer.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    period_ns: u64,
    next: Point,
    /// The timer has started.
    pub is_locked: bool,
}

impl Grid {
    pub fn new() -> Self {
        Self {
            period_ns: 0,
            next: Point::Boundary(Slot::Head),
            is_locked: false,
        }
    }

    /// The next point and its instant.
    pub fn next(&self) -> (u64, Point) {
        let within_ns = match self.next {
            Point::Boundary(slot) => slot.until_ns() - AHEAD_NS,
            Point::Window => WINDOW_MIDDLE_NS,
        };
        (self.period_ns + within_ns, self.next)
    }

    /// The nominal end of the slot that the next boundary ends, ns.
    pub fn boundary_ns(&self, slot: Slot) -> u64 {
        self.period_ns + slot.until_ns()
    }

    /// Advances to the point after the next one.
    pub fn pass(&mut self) {
        self.next = match self.next {
            Point::Boundary(Slot::Head) => Point::Window,
            Point::Window => Point::Boundary(Slot::Tail),
            Point::Boundary(Slot::Tail) => {
                self.period_ns += PERIOD_NS;
                Point::Boundary(Slot::Head)
            }
        };
    }

    /// Aligns the grid with the timer, whose period began at this instant, ns. Returns whether the
    /// grid moved; the next boundary is then that of the period's head.
    pub fn follow(&mut self, edge_ns: u64) -> bool {
        let apart_ns = (edge_ns % PERIOD_NS).abs_diff(self.period_ns % PERIOD_NS);
        let apart_ns = apart_ns.min(PERIOD_NS - apart_ns);
        if self.is_locked && apart_ns < SLACK_NS {
            return false;
        }
        self.is_locked = true;
        self.period_ns = edge_ns;
        self.next = Point::Boundary(Slot::Head);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_points_of_a_period_have_a_fixed_order() {
        let mut grid = Grid::new();
        assert!(grid.follow(3_000_000));
        let mut points = Vec::new();
        for _ in 0..4 {
            points.push(grid.next().0);
            grid.pass();
        }
        assert_eq!(points, [3_895_000, 3_950_000, 3_995_000, 4_895_000]);
    }

    #[test]
    fn an_edge_at_its_expected_instant_does_not_move_the_grid() {
        let mut grid = Grid::new();
        grid.follow(3_000_000);
        grid.pass();
        assert!(!grid.follow(9_000_012));
        assert!(!grid.follow(2_999_990));
        assert_eq!(grid.next().1, Point::Window);
        assert!(grid.follow(9_400_000));
        assert_eq!(grid.next(), (10_295_000, Point::Boundary(Slot::Head)));
    }
}
