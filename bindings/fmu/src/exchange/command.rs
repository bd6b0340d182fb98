//! The command of a continuous model, on its way through sampling and delay.
//!
//! The past of the input is kept as stretches without a jump, each a polyline through the ends of
//! the solver's steps. A jump starts a stretch; when it arrives, a time event ends the previous
//! one. The value that has arrived is therefore continuous between events.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

/// Tolerance of the instants of events, relative to the time.
const SAME: f64 = 1e-9;

type Point = (f64, f64);

/// A sampled and delayed input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Command {
    start_s: f64,
    delay_s: f64,
    /// The period of the sampling host; 0 without one.
    period_s: f64,
    /// Samples so far.
    samples: u64,
    /// The stretches that have not passed; the first is the present one.
    stretches: VecDeque<VecDeque<Point>>,
    /// The latest value of the input, which may belong to a step that is not accepted.
    latest: Point,
    /// Whether time has not passed since the start.
    is_at_start: bool,
}

fn is_reached(time_s: f64, now_s: f64) -> bool {
    time_s <= now_s + SAME * now_s.abs().max(1.0)
}

impl Command {
    /// An input that has always had this value.
    pub fn new(start_s: f64, value: f64, delay_s: f64, period_s: f64) -> Self {
        let mut new = Self {
            start_s,
            delay_s,
            period_s,
            samples: 0,
            stretches: VecDeque::new(),
            latest: (start_s, value),
            is_at_start: true,
        };
        new.restart(start_s, value);
        new
    }

    /// Clears the past: the input has always had this value.
    pub fn restart(&mut self, time_s: f64, value: f64) {
        self.latest = (time_s, value);
        self.stretches = VecDeque::from([VecDeque::from([self.latest])]);
        self.count_samples(time_s);
    }

    fn is_sampled(&self) -> bool {
        self.period_s > 0.0
    }

    fn sample_s(&self) -> f64 {
        self.start_s + self.samples as f64 * self.period_s
    }

    /// Counts the samples until now; returns whether there was one.
    fn count_samples(&mut self, now_s: f64) -> bool {
        let before = self.samples;
        while self.is_sampled() && is_reached(self.sample_s(), now_s) {
            self.samples += 1;
        }
        self.samples > before
    }

    /// Takes the value of the input at a time within a step.
    pub fn set(&mut self, time_s: f64, value: f64) {
        self.latest = (time_s, value);
    }

    /// Accepts the step that ends at this time.
    pub fn complete(&mut self, time_s: f64) {
        self.is_at_start &= is_reached(time_s, self.start_s);
        if !self.is_sampled() {
            let point = (time_s, self.latest.1);
            if let Some(last) = self.stretches.back_mut()
                && last.back().is_none_or(|end| end.0 < time_s)
            {
                last.push_back(point);
            }
        }
        let past_s = time_s - self.delay_s;
        if let Some(first) = self.stretches.front_mut() {
            while first.get(1).is_some_and(|point| point.0 <= past_s) {
                first.pop_front();
            }
        }
    }

    /// Processes an event, with the value of the input after it.
    pub fn update(&mut self, time_s: f64, value: f64) {
        if self.is_at_start && is_reached(time_s, self.start_s) {
            // The first command is also the past of the delay.
            self.samples = 0;
            self.restart(time_s, value);
            return;
        }
        let takes = !self.is_sampled() || self.count_samples(time_s);
        let last = self.stretches.back().and_then(|last| last.back());
        if takes && last.is_none_or(|last| last.1 != value) {
            self.stretches.push_back(VecDeque::from([(time_s, value)]));
        }
        self.latest = (time_s, value);
        let has_arrived = |stretch: Option<&VecDeque<Point>>| {
            let start = stretch.and_then(|stretch| stretch.front());
            start.is_some_and(|start| is_reached(start.0 + self.delay_s, time_s))
        };
        while has_arrived(self.stretches.get(1)) {
            self.stretches.pop_front();
        }
    }

    /// The time of the next event that is known.
    pub fn next_event_s(&self) -> Option<f64> {
        let start = self.stretches.get(1).and_then(|stretch| stretch.front());
        let arrival_s = start.map(|start| start.0 + self.delay_s);
        let sample_s = self.is_sampled().then(|| self.sample_s());
        match (arrival_s, sample_s) {
            (Some(arrival_s), Some(sample_s)) => Some(arrival_s.min(sample_s)),
            (one, other) => one.or(other),
        }
    }

    /// The value that has arrived at a time.
    pub fn arrived(&self, time_s: f64) -> f64 {
        let past_s = time_s - self.delay_s;
        let Some(stretch) = self.stretches.front() else {
            return self.latest.1;
        };
        let after = stretch.partition_point(|point| point.0 <= past_s);
        let Some(from) = after.checked_sub(1).and_then(|before| stretch.get(before)) else {
            return stretch.front().map_or(self.latest.1, |first| first.1);
        };
        // The end of the last stretch moves with the input.
        let moves = self.stretches.len() == 1 && !self.is_sampled();
        let latest = (moves && self.latest.0 > from.0).then_some(&self.latest);
        let Some(to) = stretch.get(after).or(latest) else {
            return from.1;
        };
        let share = ((past_s - from.0) / (to.0 - from.0)).min(1.0);
        from.1 + share * (to.1 - from.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_arrives_with_the_event_of_its_arrival_and_not_before() {
        let mut command = Command::new(0.0, 1.0, 0.5, 0.0);
        command.complete(2.0);
        command.update(2.0, 5.0);
        assert_eq!(command.next_event_s(), Some(2.5));
        for time_s in [0.0, 2.0, 2.4, 2.5, 2.6] {
            assert_eq!(command.arrived(time_s), 1.0, "{time_s}");
        }
        command.complete(2.5);
        command.update(2.5, 5.0);
        assert_eq!((command.arrived(2.5), command.next_event_s()), (5.0, None));
    }

    #[test]
    fn a_ramp_is_delayed_exactly_whatever_the_steps() {
        let mut command = Command::new(1.0, 0.0, 0.25, 0.0);
        let mut time_s = 1.0;
        for step_s in [0.01, 0.1, 0.3, 0.02, 0.6, 0.05] {
            // Within the step, before it is accepted.
            for share in [0.5, 1.0] {
                let at_s = time_s + share * step_s;
                command.set(at_s, 3.0 * (at_s - 1.0));
                let exact = 3.0 * (at_s - 1.25_f64).max(0.0);
                assert!((command.arrived(at_s) - exact).abs() < 1e-12, "{at_s}");
            }
            time_s += step_s;
            command.complete(time_s);
        }
        assert!(command.stretches[0].len() < 6, "the past is forgotten");
    }

    #[test]
    fn a_host_samples_at_its_period_and_holds() {
        let mut command = Command::new(0.0, 0.0, 0.004, 0.02);
        assert_eq!(command.next_event_s(), Some(0.02));
        command.set(0.013, 7.0);
        command.complete(0.013);
        assert_eq!(command.arrived(0.019), 0.0);
        command.update(0.02, 9.0);
        assert_eq!(command.next_event_s(), Some(0.024));
        assert_eq!(command.arrived(0.0239), 0.0);
        // An input between two samples is not seen.
        command.update(0.024, 11.0);
        assert_eq!(
            (command.arrived(0.024), command.next_event_s()),
            (9.0, Some(0.04))
        );
    }

    #[test]
    fn the_first_command_is_the_past_of_the_delay() {
        let mut command = Command::new(3.0, 0.0, 0.5, 0.0);
        command.update(3.0, 40.0);
        assert_eq!((command.arrived(3.0), command.next_event_s()), (40.0, None));
    }
}
