//! Times that a model spends at its limits.

use crate::model::ActiveLimit;

/// An interval at one limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// The limit.
    pub state: ActiveLimit,
    /// Its start, s.
    pub from_s: f64,
    /// Its end, s.
    pub to_s: f64,
}

/// The time that a model spends at its limits in one recording.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Limited {
    /// From the first to the last sample, s.
    pub duration_s: f64,
    /// At the upper rate limit, s.
    pub rate_up_s: f64,
    /// At the lower rate limit, s.
    pub rate_down_s: f64,
    /// At the duty limit, s.
    pub duty_s: f64,
    /// At a hard stop, s.
    pub stop_s: f64,
    /// Held by static friction, s.
    pub stuck_s: f64,
    /// The intervals at a rate or duty limit, in order.
    pub stretches: Vec<Stretch>,
}

impl Limited {
    /// From the active limits at increasing instants; each applies to the halves of the adjacent
    /// sample intervals.
    ///
    /// ```
    /// use identification::{ActiveLimit, assessment::Limited};
    /// let states = [ActiveLimit::Free, ActiveLimit::RateUp, ActiveLimit::RateUp, ActiveLimit::Free];
    /// let limited = Limited::of(&[0.0, 1.0, 2.0, 3.0], &states);
    /// assert_eq!((limited.rate_up_s, limited.duration_s), (2.0, 3.0));
    /// ```
    pub fn of(time_s: &[f64], states: &[ActiveLimit]) -> Self {
        let mut limited = Self::default();
        let (Some(first), Some(last)) = (time_s.first(), time_s.last()) else {
            return limited;
        };
        limited.duration_s = last - first;
        for (index, state) in states.iter().enumerate().take(time_s.len()) {
            // To the midpoints of the adjacent intervals.
            let before = time_s[index.saturating_sub(1)];
            let after = *time_s.get(index + 1).unwrap_or(last);
            let ends = [before, after].map(|t| 0.5 * (t + time_s[index]));
            limited.add(*state, ends);
        }
        limited
    }

    fn add(&mut self, state: ActiveLimit, [from_s, to_s]: [f64; 2]) {
        let sum = match state {
            ActiveLimit::Free | ActiveLimit::Off => return,
            ActiveLimit::RateUp => &mut self.rate_up_s,
            ActiveLimit::RateDown => &mut self.rate_down_s,
            ActiveLimit::Duty => &mut self.duty_s,
            ActiveLimit::Stop => &mut self.stop_s,
            ActiveLimit::Stuck => &mut self.stuck_s,
        };
        *sum += to_s - from_s;
        if matches!(state, ActiveLimit::Stop | ActiveLimit::Stuck) {
            return;
        }
        match self.stretches.last_mut() {
            Some(last) if last.state == state && last.to_s == from_s => last.to_s = to_s,
            _ => self.stretches.push(Stretch {
                state,
                from_s,
                to_s,
            }),
        }
    }

    /// Time at a rate or duty limit, s, where a linear method identifies another system.
    pub fn rate_limited_s(&self) -> f64 {
        self.rate_up_s + self.rate_down_s + self.duty_s
    }

    /// The longest interval at a rate or duty limit.
    pub fn longest(&self) -> Option<&Stretch> {
        let length = |s: &Stretch| s.to_s - s.from_s;
        let mut stretches = self.stretches.iter();
        let first = stretches.next()?;
        Some(stretches.fold(first, |a, b| if length(b) > length(a) { b } else { a }))
    }
}
