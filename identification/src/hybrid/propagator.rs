//! Propagates a linear system from sample to sample and caches its transition matrices.
//!
//! For a step length that recurs, the series are summed once and cached as matrices. A step that is
//! long against the fastest eigenvalue is split into a short remainder and the sub-steps of
//! [`StepDoubling`], at the end of each of which the guards are checked; where none is violated,
//! the whole step is again one matrix product.

use super::Command;
use super::doubling::StepDoubling;
use super::linear::LinearSystem;
use super::transition::Transition;
use crate::scalar::Scalar;

/// Whether and how the transition over a step is cached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Caching {
    /// It is not cached.
    Off,
    /// By its length and by the sign of the delay in it: -1, 0 or 1.
    Keyed(i8),
}

/// A step length, and the sign of the delay in it.
type Key = (u64, i8);

/// Cached transitions of a mode: even samples need one, with a delay three.
const CACHE_SIZE: usize = 8;

/// The product of step and fastest eigenvalue up to which no guard is violated and satisfied again
/// within a step.
const LONGEST_PART: f64 = 1.0;

/// No servo has a faster eigenvalue, rad/s.
const FASTEST_RAD_S: f64 = 2e4;

/// The last few transitions by their step lengths.
struct TransitionCache<S, const N: usize> {
    entries: Vec<(Key, Transition<S, N>)>,
    /// Index of the one that was used last.
    last: usize,
}

impl<S, const N: usize> TransitionCache<S, N> {
    const fn new() -> Self {
        Self {
            entries: Vec::new(),
            last: 0,
        }
    }

    /// The transition of a step length, which is computed where it is not cached.
    fn of(&mut self, key: Key, make: impl FnOnce() -> Transition<S, N>) -> &mut Transition<S, N> {
        self.last = match self.entries.iter().position(|t| t.0 == key) {
            Some(index) => index,
            None => self.keep((key, make())),
        };
        &mut self.entries[self.last].1
    }

    fn keep(&mut self, transition: (Key, Transition<S, N>)) -> usize {
        if self.entries.len() < CACHE_SIZE {
            self.entries.push(transition);
            return self.entries.len() - 1;
        }
        let oldest = (self.last + 1) % CACHE_SIZE;
        self.entries[oldest] = transition;
        oldest
    }
}

/// A system and its series over a step.
pub struct Series<S, const N: usize> {
    pub system: LinearSystem<S, N>,
    /// The same without derivatives.
    pub plain: LinearSystem<f64, N>,
    fastest: f64,
}

impl<S: Scalar, const N: usize> Series<S, N> {
    /// Terms after which only rounding remains: `z^k/k! < 1e-17`, and some for derivatives and for
    /// eigenvectors that are far from orthogonal.
    fn terms(&self, step_s: f64) -> usize {
        let z = (step_s * self.fastest).abs();
        let (mut terms, mut term) = (1, 1.0);
        while term > 1e-17 && terms < 60 {
            term *= z / terms as f64;
            terms += 1;
        }
        terms + 4
    }

    /// Whether a step is short: see [`LONGEST_PART`].
    fn is_short(&self, step_s: f64) -> bool {
        step_s * self.fastest <= LONGEST_PART
    }

    /// Over a short step.
    fn short(&self, step: S) -> Transition<S, N> {
        Transition::new(&self.system, step, self.terms(step.value()))
    }

    /// Over a step of any length: a short step, doubled repeatedly.
    fn long(&self, step: S) -> Transition<S, N> {
        let parts = (step.value() * self.fastest / LONGEST_PART).max(1.0);
        let doublings = parts.log2().ceil();
        let mut transition = self.short(step * (-doublings).exp2());
        transition.make_moments(&self.system);
        for _ in 0..doublings as usize {
            transition = transition.doubled();
        }
        transition
    }
}

/// A system with its cached results.
pub struct Propagator<S, const N: usize> {
    pub series: Series<S, N>,
    short: TransitionCache<S, N>,
    long: TransitionCache<S, N>,
    pub doubling: StepDoubling<S, N>,
}

impl<S: Scalar, const N: usize> Propagator<S, N> {
    pub fn new(system: LinearSystem<S, N>) -> Self {
        let fastest = system.fastest();
        Self {
            doubling: StepDoubling::new(LONGEST_PART / fastest.max(1e-9)),
            series: Series {
                plain: system.without_derivatives(),
                system,
                fastest,
            },
            short: TransitionCache::new(),
            long: TransitionCache::new(),
        }
    }

    /// Whether it is too fast to be simulated, or NaN.
    pub fn is_too_fast(&self) -> bool {
        self.series.fastest.is_nan() || self.series.fastest > FASTEST_RAD_S
    }

    /// Splits a step into a short remainder, which depends on the parameters as the step does, and
    /// a number of base lengths.
    pub fn split(&self, step: S) -> (S, u64) {
        if self.series.is_short(step.value()) {
            (step, 0)
        } else {
            self.doubling.split(step)
        }
    }

    /// The state after a sub-step of a level.
    pub fn advance_level(&mut self, x: &[S; N], command: &Command<S>, level: usize) -> [S; N] {
        if self.doubling.is_empty() {
            let base = S::constant(self.doubling.level_s(0));
            self.doubling.set_base(self.series.short(base));
        }
        self.doubling
            .advance_level(x, command, level, &self.series.system)
    }

    /// The state after a short step, without the cache.
    pub fn solve(&self, x: &[S; N], command: &Command<S>, step: S) -> [S; N] {
        let terms = self.series.terms(step.value());
        self.series.system.solve(x, command, step, terms)
    }

    /// The same without derivatives.
    pub fn solve_plain(&self, x: &[f64; N], command: &Command<f64>, step_s: f64) -> [f64; N] {
        let terms = self.series.terms(step_s);
        self.series.plain.solve(x, command, step_s, terms)
    }

    /// The state after the short step that was used last, under a constant command; `None` where
    /// the last step had another length.
    #[inline(always)]
    pub fn repeat(&mut self, x: &[S; N], command: f64, step_s: f64) -> Option<[S; N]> {
        let (key, transition) = self.short.entries.get_mut(self.short.last)?;
        (*key == (step_s.to_bits(), 0)).then(|| transition.under_held_command(x, command))
    }

    /// The state after a short step, with the cached transition.
    pub fn propagate(
        &mut self,
        x: &[S; N],
        command: &Command<S>,
        step: S,
        caching: Caching,
    ) -> [S; N] {
        let Caching::Keyed(side) = caching else {
            return self.solve(x, command, step);
        };
        let key = (step.value().to_bits(), side);
        let transition = self.short.of(key, || self.series.short(step));
        transition.apply(x, command, &self.series.system)
    }

    /// The state after a long step that stays within the mode, with the cached transition.
    pub fn long_step(&mut self, x: &[S; N], command: &Command<S>, step: S, side: i8) -> [S; N] {
        let key = (step.value().to_bits(), side);
        let transition = self.long.of(key, || self.series.long(step));
        transition.apply(x, command, &self.series.system)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Dual;

    type Step = Dual<1>;

    /// An inner loop of 10,000 1/s, 40 times as fast as the samples.
    fn system() -> LinearSystem<Step, 2> {
        let a = [[0.0, 1.0], [-3e5, -1e4]].map(|row| row.map(Step::constant));
        LinearSystem {
            a,
            b: [0.0, 3e5].map(Step::constant),
            d: [0.0, -2.0].map(Step::constant),
        }
    }

    #[test]
    fn a_long_step_ends_where_short_steps_end_and_depends_on_its_length_as_they_do() {
        let mut linear = Propagator::new(system());
        let start = [1.5, -20.0].map(Step::constant);
        let step = Step::parameter(0.0039, 0);
        for command in [
            Command::Constant(3.0),
            Command::Cubic([3.0, -4.0, 50.0, 700.0].map(Step::constant)),
        ] {
            let (rest, steps) = linear.split(step);
            assert!(steps > 20, "{steps}");
            let mut along = linear.solve(&start, &command, rest);
            let mut later = command.later(rest);
            for _ in 0..steps {
                along = linear.advance_level(&along, &later, 0);
                later = later.later(Step::constant(linear.doubling.level_s(0)));
            }
            let at_once = linear.long_step(&start, &command, step, 0);
            for (at_once, along) in at_once.iter().zip(along) {
                // Rounding of rates of 1e4 deg/s on the way, and of their derivatives of 1e8.
                assert!(
                    (at_once.value - along.value).abs() < 1e-9,
                    "{at_once:?} {along:?}"
                );
                let slope = (at_once.slope[0] - along.slope[0]).abs();
                assert!(slope < 1e-5, "{at_once:?} {along:?}");
            }
        }
    }
}
