//! A long step as a sequence of sub-steps whose lengths double: fast eigenmodes have settled before
//! the long sub-steps, so that a servo that is fast against its samples needs a few matrix products
//! instead of a hundred series.

use super::Command;
use super::linear::LinearSystem;
use super::transition::Transition;
use crate::scalar::Scalar;

/// A sub-step is at most this share of the time since the step began, by which fast eigenmodes have
/// settled.
const SHARE: u64 = 4;

/// Transitions over a base length, twice that, and so on: level `n` spans `2^n` base lengths.
pub struct StepDoubling<S, const N: usize> {
    steps: Vec<Transition<S, N>>,
    base_s: f64,
}

impl<S: Scalar, const N: usize> StepDoubling<S, N> {
    /// With a base length of at most `most_s`.
    pub fn new(most_s: f64) -> Self {
        Self {
            steps: Vec::new(),
            // A power of two: multiples of it are exact.
            base_s: most_s.log2().floor().exp2(),
        }
    }

    /// Splits a step into a remainder and a number of base lengths.
    pub fn split(&self, step: S) -> (S, u64) {
        // `as` takes NaN to 0 and saturates.
        let steps = (step.value() / self.base_s) as u64;
        (step + steps as f64 * -self.base_s, steps)
    }

    /// The level of the next sub-step after `done` base lengths, of which `left` are left.
    pub fn next(done: u64, left: u64) -> usize {
        let settled = (done / SHARE).max(1).ilog2();
        settled.min(left.max(1).ilog2()) as usize
    }

    /// Length of a level, s.
    pub fn level_s(&self, level: usize) -> f64 {
        self.base_s * (1u64 << level.min(63)) as f64
    }

    /// Whether the transition over the base length is missing.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// Sets the transition over the base length.
    pub fn set_base(&mut self, base: Transition<S, N>) {
        self.steps.push(base);
    }

    /// The state after a sub-step of a level, `system` being that of the transitions.
    pub fn advance_level(
        &mut self,
        x: &[S; N],
        command: &Command<S>,
        level: usize,
        system: &LinearSystem<S, N>,
    ) -> [S; N] {
        let is_still = matches!(command, Command::Constant(_));
        if let Some(base) = self
            .steps
            .first_mut()
            .filter(|r| !is_still && !r.has_moments())
        {
            base.make_moments(system);
            self.steps.truncate(1);
        }
        while self.steps.len() <= level {
            let last = &self.steps[self.steps.len() - 1];
            self.steps.push(last.doubled());
        }
        self.steps[level].apply(x, command, system)
    }
}
