//! The points of the interpolated position mode, 60C1h.
//!
//! They wait here, and one is posted in each interpolation period: the loop moves to each within
//! that time. It begins once two wait, or one has waited for a period: a master whose points come
//! early or late by less than a period makes no pause.

/// Points of the buffer, 60C4h:1.
const POINTS: usize = 16;

/// The points, as the axis counts them, mdeg.
#[derive(Debug, Clone, Copy, Default)]
pub struct Points {
    /// 60C1h:1, written last.
    pub(super) last: i32,
    points: [i32; POINTS],
    /// The number of points, the oldest first.
    waiting: usize,
    /// Time until the next point is due, us; `None` before the first.
    due_us: Option<i32>,
    /// For how long the first point has waited, us.
    waited_us: i32,
}

impl Points {
    /// Points that wait.
    pub fn waiting(&self) -> usize {
        self.waiting
    }

    /// Discards the newest ones, so that at most so many wait.
    pub fn truncate(&mut self, waiting: usize) {
        self.waiting = self.waiting.min(waiting);
    }

    /// Appends a point; returns false, without effect, if the buffer is full.
    #[must_use]
    pub(super) fn append(&mut self, point: i32) -> bool {
        let free = self.points.get_mut(self.waiting);
        let is_accepted = free.map(|free| *free = point).is_some();
        if is_accepted {
            self.waiting += 1;
            self.last = point;
        }
        is_accepted
    }

    /// Discards the points.
    pub(super) fn clear(&mut self) {
        (self.waiting, self.due_us, self.waited_us) = (0, None, 0);
    }

    /// Time passes while the loop interpolates; returns the point that is due.
    pub(super) fn next(&mut self, passed_us: i32, period_us: i32) -> Option<i32> {
        let due_us = match self.due_us {
            Some(due_us) => due_us.saturating_sub(passed_us),
            None if self.waiting == 0 => return None,
            None => {
                self.waited_us = self.waited_us.saturating_add(passed_us);
                let is_enough = self.waiting > 1 || self.waited_us > period_us;
                if is_enough { 0 } else { 1 }
            }
        };
        if due_us > 0 {
            self.due_us = self.due_us.map(|_| due_us);
            return None;
        }
        self.waited_us = 0;
        let next = self.points.first().copied().filter(|_| self.waiting > 0);
        if next.is_some() {
            self.points.rotate_left(1);
            self.waiting -= 1;
        }
        self.due_us = next.map(|_| due_us.saturating_add(period_us));
        next
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    /// The points that are due in control periods of 4 ms, for a master that writes in some.
    fn due(written: &[usize], periods: usize) -> Vec<(usize, i32)> {
        let mut points = Points::default();
        let mut due = Vec::new();
        for at in 0..periods {
            if let Some(number) = written.iter().position(|period| *period == at) {
                assert!(points.append(number as i32));
            }
            due.extend(points.next(4_000, 20_000).map(|point| (at, point)));
        }
        due
    }

    #[test]
    fn points_that_come_early_or_late_are_due_in_equal_intervals() {
        let due = due(&[0, 5, 14, 16, 20, 29, 31], 45);
        let expected: Vec<_> = (0..7).map(|point| (5 + 5 * point, point as i32)).collect();
        assert_eq!(due, expected);
    }

    #[test]
    fn one_point_waits_for_a_period_and_a_gap_begins_anew() {
        assert_eq!(due(&[0, 20, 22], 40), [(5, 0), (22, 1), (27, 2)]);
    }

    #[test]
    fn a_full_buffer_refuses_a_point_and_can_be_cleared() {
        let mut points = Points::default();
        assert!((0..POINTS as i32).all(|point| points.append(point)));
        assert!(!points.append(16));
        assert_eq!((points.waiting(), points.last), (16, 15));
        points.clear();
        assert_eq!((points.waiting(), points.next(4_000, 20_000)), (0, None));
    }
}
