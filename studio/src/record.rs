//! The samples of an actuator: those of the last minutes, and those that the pages lack.

use std::collections::{BTreeMap, VecDeque};

use host_sim::can::telemetry::Clock;
use model_core::time::CONTROL_RATE_HZ;

use crate::quantity::COUNT;
use crate::web::PageId;

/// Minutes that are kept of each of up to [`FULL_NODES`] actuators.
pub const MINUTES: usize = 5;

/// Rows that are kept of each actuator.
pub const ROWS: usize = MINUTES * 60 * CONTROL_RATE_HZ as usize;

/// Rows of the longest recording: an hour, 36 MB.
const LONGEST: usize = 3600 * CONTROL_RATE_HZ as usize;

/// Actuators with a full ring: of more, each keeps less, so that the memory has a bound of 24 MB.
const FULL_NODES: usize = 8;

/// A pause, or a jump of the counter, above which the time is taken from the computer again, s.
const GAP_S: f64 = 1.0;

/// A sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Time since the start of the program, s.
    pub time_s: f64,
    /// The quantities of the bus; what is behind them has no meaning.
    pub values: [f32; COUNT],
}

/// The samples of one actuator.
#[derive(Debug, Default)]
pub struct Record {
    clock: Clock,
    /// Time of the clock's zero, s.
    origin_s: Option<f64>,
    last_s: f64,
    /// Samples that did not arrive, by the counter of the actuator.
    pub lost: u64,
    /// Samples lost since the last report to the pages.
    pub dropped: u64,
    /// The last rows.
    pub ring: VecDeque<Row>,
    /// Rows that the pages lack.
    pub pending: Vec<Row>,
    /// The pages that record, and since when, s: these rows are kept.
    kept: BTreeMap<PageId, f64>,
}

/// Rows that wait for the next message to the pages: half a second.
const PENDING: usize = CONTROL_RATE_HZ as usize / 2;

impl Record {
    /// A sample with the counter of the actuator, `now_s` after the start of the program; `nodes`
    /// actuators share the memory.
    pub fn push(&mut self, counter: Option<u16>, now_s: f64, values: [f32; COUNT], nodes: usize) {
        let time_s = self.time_s(counter, now_s);
        let row = Row { time_s, values };
        let most = ROWS * FULL_NODES / nodes.max(FULL_NODES);
        while self.ring.len() >= most && !self.is_kept() {
            self.ring.pop_front();
        }
        if self.kept.is_empty() {
            self.ring.shrink_to(most);
        }
        if self.ring.capacity() < most {
            // Growing by doubling would touch memory long after the ring is full.
            self.ring.reserve_exact(most - self.ring.len());
        }
        self.ring.push_back(row);
        if self.pending.len() < PENDING {
            self.pending.push(row);
        } else {
            self.dropped += 1;
        }
    }

    /// Keeps all rows from now on for a page, for an hour at most.
    pub fn keep(&mut self, page: PageId, now_s: f64) {
        self.kept.insert(page, now_s);
    }

    /// Ends the recording of a page.
    pub fn release(&mut self, page: PageId) {
        self.kept.remove(&page);
    }

    /// Whether the oldest row belongs to a recording.
    fn is_kept(&self) -> bool {
        let oldest = self.ring.front();
        self.ring.len() < LONGEST
            && oldest.is_some_and(|row| self.kept.values().any(|from| row.time_s >= *from))
    }

    /// The time of a sample: by the counter, whose period is exact, unless there was a gap.
    fn time_s(&mut self, counter: Option<u16>, now_s: f64) -> f64 {
        let Some(counter) = counter else {
            self.last_s = now_s;
            return now_s;
        };
        if now_s - self.last_s > GAP_S || self.origin_s.is_none() {
            self.begin_anew(now_s);
        }
        let lost_before = self.clock.lost;
        let since_s = self.clock.time_s(counter);
        let time_s = self.origin_s.unwrap_or(now_s) + since_s;
        if time_s - now_s > GAP_S {
            // The actuator has started anew, and so has its counter.
            self.begin_anew(now_s);
            self.clock.time_s(counter);
            self.last_s = now_s;
            return now_s;
        }
        self.lost += self.clock.lost - lost_before;
        self.last_s = now_s;
        time_s
    }

    fn begin_anew(&mut self, now_s: f64) {
        self.clock = Clock::default();
        self.origin_s = Some(now_s);
    }

    /// The rows from one time to another, s.
    pub fn rows(&self, from_s: f64, to_s: f64) -> impl Iterator<Item = &Row> {
        let rows = self.ring.iter();
        rows.filter(move |row| (from_s..=to_s).contains(&row.time_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(record: &Record) -> Vec<f64> {
        record.ring.iter().map(|row| row.time_s).collect()
    }

    #[test]
    fn the_time_is_that_of_the_counter_and_losses_are_counted() {
        let mut record = Record::default();
        for (counter, now_s) in [(65_534, 5.0), (65_535, 5.1), (0, 5.1), (3, 5.1)] {
            record.push(Some(counter), now_s, [0.0; COUNT], 1);
        }
        let expected = [5.0, 5.004, 5.008, 5.02];
        for (time_s, expected) in times(&record).into_iter().zip(expected) {
            assert!((time_s - expected).abs() < 1e-9, "{time_s}");
        }
        assert_eq!(record.lost, 2);
    }

    #[test]
    fn after_a_pause_or_a_restart_the_time_is_that_of_the_computer() {
        let mut record = Record::default();
        record.push(Some(100), 5.0, [0.0; COUNT], 1);
        // A pause of the bus.
        record.push(Some(50_000), 8.0, [0.0; COUNT], 1);
        // A restart of the actuator.
        record.push(Some(1), 8.5, [0.0; COUNT], 1);
        assert_eq!(times(&record), [5.0, 8.0, 8.5]);
        assert_eq!(record.lost, 0);
    }

    #[test]
    fn a_recording_is_kept_until_it_ends_and_for_an_hour_at_most() {
        let mut record = Record::default();
        let push = |record: &mut Record, from: usize, to: usize| {
            (from..to).for_each(|row| record.push(None, row as f64, [0.0; COUNT], 1));
        };
        push(&mut record, 0, 10);
        record.keep(7, 10.0);
        push(&mut record, 10, 2 * ROWS);
        assert_eq!(record.rows(10.0, f64::MAX).count(), 2 * ROWS - 10);
        record.release(7);
        push(&mut record, 2 * ROWS, 2 * ROWS + 1);
        assert_eq!(record.ring.len(), ROWS);
        record.keep(7, 0.0);
        push(&mut record, 0, LONGEST);
        assert_eq!(record.ring.len(), LONGEST);
    }

    #[test]
    fn the_memory_has_a_bound() {
        let mut record = Record::default();
        for row in 0..2 * ROWS {
            record.push(None, row as f64, [0.0; COUNT], 16);
        }
        assert_eq!(record.ring.len(), ROWS / 2);
        assert_eq!(record.pending.len(), PENDING);
        assert_eq!(record.dropped as usize, 2 * ROWS - PENDING);
    }
}
