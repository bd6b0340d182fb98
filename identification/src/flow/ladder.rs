//! A long step in rungs, each twice as long as the one below it: what is fast has settled when the long ones
//! come, so that a servo that is fast against its samples takes a few products and no hundred series.

use super::Command;
use super::linear::System;
use super::transition::Transition;
use crate::scalar::Scalar;

/// A rung is at most this share of the time since the step began: what is fast has settled by then.
const SHARE: u64 = 4;

/// Transitions over a length, twice that, and so on.
pub struct Ladder<S, const N: usize> {
    rungs: Vec<Transition<S, N>>,
    lowest_s: f64,
}

impl<S: Scalar, const N: usize> Ladder<S, N> {
    /// One whose lowest rung is at most so long.
    pub fn new(most_s: f64) -> Self {
        Self {
            rungs: Vec::new(),
            // A power of two: multiples of it are exact.
            lowest_s: most_s.log2().floor().exp2(),
        }
    }

    /// A step as a rest and so many of the lowest rung.
    pub fn cut(&self, step: S) -> (S, u64) {
        // `as` takes NaN to 0 and saturates.
        let rungs = (step.value() / self.lowest_s) as u64;
        (step + rungs as f64 * -self.lowest_s, rungs)
    }

    /// The rung to be taken after `done` of the lowest ones, of which `left` are left.
    pub fn next(done: u64, left: u64) -> usize {
        let calm = (done / SHARE).max(1).ilog2();
        calm.min(left.max(1).ilog2()) as usize
    }

    /// Length of a rung, s.
    pub fn rung_s(&self, rung: usize) -> f64 {
        self.lowest_s * (1u64 << rung.min(63)) as f64
    }

    /// Whether there is no rung yet.
    pub fn is_empty(&self) -> bool {
        self.rungs.is_empty()
    }

    /// Takes the transition over the lowest rung.
    pub fn begin(&mut self, lowest: Transition<S, N>) {
        self.rungs.push(lowest);
    }

    /// The state after a rung, `system` being that of the lowest one.
    pub fn climb(
        &mut self,
        x: &[S; N],
        command: &Command<S>,
        rung: usize,
        system: &System<S, N>,
    ) -> [S; N] {
        let is_still = matches!(command, Command::Constant(_));
        if let Some(lowest) = self
            .rungs
            .first_mut()
            .filter(|r| !is_still && !r.has_moments())
        {
            lowest.make_moments(system);
            self.rungs.truncate(1);
        }
        while self.rungs.len() <= rung {
            let last = &self.rungs[self.rungs.len() - 1];
            self.rungs.push(last.twice());
        }
        self.rungs[rung].apply(x, command, system)
    }
}
