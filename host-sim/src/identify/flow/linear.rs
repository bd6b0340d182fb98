//! The exact solution of `x' = A x + b c + d` for a command that is a cubic polynomial.
//!
//! Its Taylor series is summed to rounding over steps that are short against the fastest eigenvalue.
//! For a length that comes again, the series are summed once and kept as matrices. A longer step is
//! cut into a short rest and rungs of a ladder, each twice as long as the one below it: a servo that
//! is fast against its samples takes a few products from sample to sample and no hundred series.

use super::Command;
use super::transition::Transition;
use crate::identify::scalar::Scalar;

/// The equations of a mode.
#[derive(Debug, Clone, Copy)]
pub struct System<S, const N: usize> {
    /// `A`, by rows.
    pub a: [[S; N]; N],
    /// `b`.
    pub b: [S; N],
    /// `d`.
    pub d: [S; N],
}

impl<S: Scalar, const N: usize> System<S, N> {
    fn without_derivatives(&self) -> System<f64, N> {
        System {
            a: std::array::from_fn(|i| super::values(&self.a[i])),
            b: super::values(&self.b),
            d: super::values(&self.d),
        }
    }

    /// `A x`.
    #[inline(always)]
    pub fn apply(&self, x: &[S; N]) -> [S; N] {
        let mut sums = [S::constant(0.0); N];
        for (sum, row) in sums.iter_mut().zip(&self.a) {
            *sum = row[0] * x[0];
            for j in 1..N {
                *sum = *sum + row[j] * x[j];
            }
        }
        sums
    }

    /// `A x + b c + d`.
    pub fn rates(&self, x: &[S; N], command: S) -> [S; N] {
        let mut rates = self.apply(x);
        for (i, rate) in rates.iter_mut().enumerate() {
            *rate = *rate + self.b[i] * command + self.d[i];
        }
        rates
    }

    /// `x` after `step`: `X_{k+1} = (A X_k + b q_k + d [k = 0]) step/(k + 1)`.
    pub fn solve(&self, x: &[S; N], command: &Command<S>, step: S, terms: usize) -> [S; N] {
        let mut power = S::constant(1.0);
        self.series(x, step, terms, |k, next| match command {
            Command::Constant(value) if k == 0 => {
                add(next, &self.b, S::constant(*value));
                add(next, &self.d, S::constant(1.0));
            }
            Command::Constant(_) => {}
            Command::Cubic(q) => {
                if let Some(q) = q.get(k) {
                    let force = *q * power;
                    add(next, &self.b, force);
                    power = power * step;
                }
                if k == 0 {
                    add(next, &self.d, S::constant(1.0));
                }
            }
        })
    }

    /// The series that begins with `x`; `force` adds to its derivatives.
    #[inline(always)]
    pub fn series(
        &self,
        x: &[S; N],
        step: S,
        terms: usize,
        mut force: impl FnMut(usize, &mut [S; N]),
    ) -> [S; N] {
        let (mut sum, mut term) = (*x, *x);
        for k in 0..terms {
            let factor = step * (1.0 / (k + 1) as f64);
            let mut next = self.apply(&term);
            force(k, &mut next);
            for i in 0..N {
                next[i] = next[i] * factor;
                sum[i] = sum[i] + next[i];
            }
            term = next;
        }
        sum
    }

    /// The greatest magnitude of an eigenvalue, from above: the eighth root of the norm of `A^8`.
    fn fastest(&self) -> f64 {
        let mut power: [[f64; N]; N] = std::array::from_fn(|i| super::values(&self.a[i]));
        for _ in 0..3 {
            power = std::array::from_fn(|i| {
                std::array::from_fn(|j| (0..N).map(|k| power[i][k] * power[k][j]).sum())
            });
        }
        let norm: f64 = power.iter().flatten().map(|x| x * x).sum();
        norm.powf(1.0 / 16.0)
    }
}

/// Adds `factor more`.
#[inline(always)]
pub fn add<S: Scalar, const N: usize>(sums: &mut [S; N], more: &[S; N], factor: S) {
    for (sum, more) in sums.iter_mut().zip(more) {
        *sum = *sum + *more * factor;
    }
}

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

/// A rung is at most this share of the time since the step began: what is fast has settled by then.
const SHARE: u64 = 4;

/// A system with what has been computed of it.
pub struct Propagator<S, const N: usize> {
    pub system: System<S, N>,
    /// The same without derivatives.
    pub plain: System<f64, N>,
    fastest: f64,
    kept: Vec<(Key, Transition<S, N>)>,
    /// The one that was used last.
    last: usize,
    /// Transitions over `rung_s`, twice that, and so on.
    ladder: Vec<Transition<S, N>>,
    rung_s: f64,
}

impl<S: Scalar, const N: usize> Propagator<S, N> {
    pub fn new(system: System<S, N>) -> Self {
        let fastest = system.fastest();
        Self {
            plain: system.without_derivatives(),
            // A power of two: multiples of it are exact.
            rung_s: (LONGEST_PART / fastest.max(1e-9)).log2().floor().exp2(),
            fastest,
            system,
            kept: Vec::new(),
            last: 0,
            ladder: Vec::new(),
        }
    }

    /// Whether it is too fast to be followed, or no system at all.
    pub fn is_too_fast(&self) -> bool {
        self.fastest.is_nan() || self.fastest > FASTEST_RAD_S
    }

    /// A step as a short rest, which depends on the parameters as the step does, and so many of the
    /// lowest rung.
    pub fn cut(&self, step: S) -> (S, u64) {
        if step.value() * self.fastest <= LONGEST_PART {
            return (step, 0);
        }
        // `as` takes NaN to 0 and saturates.
        let rungs = (step.value() / self.rung_s) as u64;
        (step + rungs as f64 * -self.rung_s, rungs)
    }

    /// The rung to be taken after `done` of the lowest ones, of which `left` are left.
    pub fn rung(done: u64, left: u64) -> usize {
        let calm = (done / SHARE).max(1).ilog2();
        calm.min(left.max(1).ilog2()) as usize
    }

    /// Length of a rung, s.
    pub fn rung_s(&self, rung: usize) -> f64 {
        self.rung_s * (1u64 << rung.min(63)) as f64
    }

    /// The state after a rung.
    pub fn climb(&mut self, x: &[S; N], command: &Command<S>, rung: usize) -> [S; N] {
        while self.ladder.len() <= rung {
            let next = match self.ladder.last() {
                Some(last) => last.twice(),
                None => self.transition(S::constant(self.rung_s)),
            };
            self.ladder.push(next);
        }
        if matches!(command, Command::Cubic(_)) && !self.ladder[rung].has_moments() {
            self.ladder[0].make_moments(&self.system);
            for upper in 1..=rung {
                let (below, above) = self.ladder.split_at_mut(upper);
                above[0].make_moments_from(&below[upper - 1]);
            }
        }
        self.ladder[rung].apply(x, command, &self.system)
    }

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

    fn transition(&self, step: S) -> Transition<S, N> {
        Transition::new(&self.system, step, self.terms(step.value()))
    }

    /// The state after a short step, from scratch.
    pub fn solve(&self, x: &[S; N], command: &Command<S>, step: S) -> [S; N] {
        let terms = self.terms(step.value());
        self.system.solve(x, command, step, terms)
    }

    /// The same without derivatives.
    pub fn solve_plain(&self, x: &[f64; N], command: &Command<f64>, step_s: f64) -> [f64; N] {
        self.plain.solve(x, command, step_s, self.terms(step_s))
    }

    /// The state after a step that was used last, under a command that stands still; `None` where
    /// the last one was another.
    #[inline(always)]
    pub fn again(&mut self, x: &[S; N], command: f64, step_s: f64) -> Option<[S; N]> {
        let (key, transition) = self.kept.get_mut(self.last)?;
        (*key == (step_s.to_bits(), 0)).then(|| transition.hold(x, command))
    }

    /// The state after a short step, by what is kept for its length.
    pub fn propagate(&mut self, x: &[S; N], command: &Command<S>, step: S, kept: Kept) -> [S; N] {
        let Kept::As(side) = kept else {
            return self.solve(x, command, step);
        };
        let key = (step.value().to_bits(), side);
        self.last = match self.kept.iter().position(|t| t.0 == key) {
            Some(index) => index,
            None => self.keep(key, step),
        };
        self.kept[self.last].1.apply(x, command, &self.system)
    }

    fn keep(&mut self, key: Key, step: S) -> usize {
        let transition = (key, self.transition(step));
        if self.kept.len() < MOST_KEPT {
            self.kept.push(transition);
            return self.kept.len() - 1;
        }
        let oldest = (self.last + 1) % MOST_KEPT;
        self.kept[oldest] = transition;
        oldest
    }
}
