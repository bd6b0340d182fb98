//! A system from sample to sample, with what has been computed of it.
//!
//! For a step length that comes again, the series are summed once and kept as matrices. A step that is long
//! against the fastest eigenvalue is cut into a short rest and the rungs of a [`Ladder`], at the end of each of
//! which limits are looked for; where none is passed, all of it is one product again.

use super::Command;
use super::ladder::Ladder;
use super::linear::System;
use super::transition::Transition;
use crate::scalar::Scalar;

/// How a step length is known again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kept {
    /// It is not kept.
    No,
    /// By its length and by which way the delay moves its ends, -1, 0 or 1.
    As(i8),
}

/// A step length, and which way the delay moves its ends.
type Key = (u64, i8);

/// Transitions that are kept of a mode: even samples have one, with a delay three.
const MOST_KEPT: usize = 8;

/// The most of `step times fastest eigenvalue` within which no limit is passed unseen.
const LONGEST_PART: f64 = 1.0;

/// A model with an eigenvalue beyond this is none of a servo, rad/s.
const FASTEST_RAD_S: f64 = 2e4;

/// Transitions by their lengths, the last few of them.
struct Store<S, const N: usize> {
    kept: Vec<(Key, Transition<S, N>)>,
    /// The one that was used last.
    last: usize,
}

impl<S, const N: usize> Store<S, N> {
    const fn new() -> Self {
        Self {
            kept: Vec::new(),
            last: 0,
        }
    }

    /// The one of a length, which is made where it is not kept.
    fn of(&mut self, key: Key, make: impl FnOnce() -> Transition<S, N>) -> &mut Transition<S, N> {
        self.last = match self.kept.iter().position(|t| t.0 == key) {
            Some(index) => index,
            None => self.keep((key, make())),
        };
        &mut self.kept[self.last].1
    }

    fn keep(&mut self, transition: (Key, Transition<S, N>)) -> usize {
        if self.kept.len() < MOST_KEPT {
            self.kept.push(transition);
            return self.kept.len() - 1;
        }
        let oldest = (self.last + 1) % MOST_KEPT;
        self.kept[oldest] = transition;
        oldest
    }
}

/// A system and the steps that its series make.
pub struct Series<S, const N: usize> {
    pub system: System<S, N>,
    /// The same without derivatives.
    pub plain: System<f64, N>,
    fastest: f64,
}

impl<S: Scalar, const N: usize> Series<S, N> {
    /// Terms after which the series has rounding left: `z^k/k! < 1e-17`, and some for
    /// derivatives and for eigenvectors that are far from orthogonal.
    fn terms(&self, step_s: f64) -> usize {
        let z = (step_s * self.fastest).abs();
        let (mut terms, mut term) = (1, 1.0);
        while term > 1e-17 && terms < 60 {
            term *= z / terms as f64;
            terms += 1;
        }
        terms + 4
    }

    /// Whether no limit is passed unseen within a step, and its series is short.
    fn is_short(&self, step_s: f64) -> bool {
        step_s * self.fastest <= LONGEST_PART
    }

    /// Over a short step.
    fn short(&self, step: S) -> Transition<S, N> {
        Transition::new(&self.system, step, self.terms(step.value()))
    }

    /// Over a step of any length: over a short one, and so often twice that.
    fn long(&self, step: S) -> Transition<S, N> {
        let parts = (step.value() * self.fastest / LONGEST_PART).max(1.0);
        let doublings = parts.log2().ceil();
        let mut transition = self.short(step * (-doublings).exp2());
        transition.make_moments(&self.system);
        for _ in 0..doublings as usize {
            transition = transition.twice();
        }
        transition
    }
}

/// A system with what has been computed of it.
pub struct Propagator<S, const N: usize> {
    pub series: Series<S, N>,
    short: Store<S, N>,
    long: Store<S, N>,
    pub ladder: Ladder<S, N>,
}

impl<S: Scalar, const N: usize> Propagator<S, N> {
    pub fn new(system: System<S, N>) -> Self {
        let fastest = system.fastest();
        Self {
            ladder: Ladder::new(LONGEST_PART / fastest.max(1e-9)),
            series: Series {
                plain: system.without_derivatives(),
                system,
                fastest,
            },
            short: Store::new(),
            long: Store::new(),
        }
    }

    /// Whether it is too fast to be followed, or no system at all.
    pub fn is_too_fast(&self) -> bool {
        self.series.fastest.is_nan() || self.series.fastest > FASTEST_RAD_S
    }

    /// A step as a short rest, which depends on the parameters as the step does, and so many of the
    /// lowest rung.
    pub fn cut(&self, step: S) -> (S, u64) {
        if self.series.is_short(step.value()) {
            (step, 0)
        } else {
            self.ladder.cut(step)
        }
    }

    /// The state after a rung.
    pub fn climb(&mut self, x: &[S; N], command: &Command<S>, rung: usize) -> [S; N] {
        if self.ladder.is_empty() {
            let lowest = S::constant(self.ladder.rung_s(0));
            self.ladder.begin(self.series.short(lowest));
        }
        self.ladder.climb(x, command, rung, &self.series.system)
    }

    /// The state after a short step, from scratch.
    pub fn solve(&self, x: &[S; N], command: &Command<S>, step: S) -> [S; N] {
        let terms = self.series.terms(step.value());
        self.series.system.solve(x, command, step, terms)
    }

    /// The same without derivatives.
    pub fn solve_plain(&self, x: &[f64; N], command: &Command<f64>, step_s: f64) -> [f64; N] {
        let terms = self.series.terms(step_s);
        self.series.plain.solve(x, command, step_s, terms)
    }

    /// The state after a short step that was used last, under a command that stands still; `None` where
    /// the last one was another.
    #[inline(always)]
    pub fn again(&mut self, x: &[S; N], command: f64, step_s: f64) -> Option<[S; N]> {
        let (key, transition) = self.short.kept.get_mut(self.short.last)?;
        (*key == (step_s.to_bits(), 0)).then(|| transition.hold(x, command))
    }

    /// The state after a short step, by what is kept for its length.
    pub fn propagate(&mut self, x: &[S; N], command: &Command<S>, step: S, kept: Kept) -> [S; N] {
        let Kept::As(side) = kept else {
            return self.solve(x, command, step);
        };
        let key = (step.value().to_bits(), side);
        let transition = self.short.of(key, || self.series.short(step));
        transition.apply(x, command, &self.series.system)
    }

    /// The state after a long step within which no limit is passed, by what is kept for its length.
    pub fn leap(&mut self, x: &[S; N], command: &Command<S>, step: S, side: i8) -> [S; N] {
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
    fn system() -> System<Step, 2> {
        let a = [[0.0, 1.0], [-3e5, -1e4]].map(|row| row.map(Step::constant));
        System {
            a,
            b: [0.0, 3e5].map(Step::constant),
            d: [0.0, -2.0].map(Step::constant),
        }
    }

    #[test]
    fn a_leap_ends_where_short_steps_end_and_depends_on_its_length_as_they_do() {
        let mut linear = Propagator::new(system());
        let start = [1.5, -20.0].map(Step::constant);
        let step = Step::parameter(0.0039, 0);
        for command in [
            Command::Constant(3.0),
            Command::Cubic([3.0, -4.0, 50.0, 700.0].map(Step::constant)),
        ] {
            let (rest, rungs) = linear.cut(step);
            assert!(rungs > 20, "{rungs}");
            let mut along = linear.solve(&start, &command, rest);
            let mut later = command.later(rest);
            for _ in 0..rungs {
                along = linear.climb(&along, &later, 0);
                later = later.later(Step::constant(linear.ladder.rung_s(0)));
            }
            let leapt = linear.leap(&start, &command, step, 0);
            for (leapt, along) in leapt.iter().zip(along) {
                // Rounding of rates of 1e4 deg/s on the way, and of their derivatives of 1e8.
                assert!(
                    (leapt.value - along.value).abs() < 1e-9,
                    "{leapt:?} {along:?}"
                );
                let slope = (leapt.slope[0] - along.slope[0]).abs();
                assert!(slope < 1e-5, "{leapt:?} {along:?}");
            }
        }
    }
}
