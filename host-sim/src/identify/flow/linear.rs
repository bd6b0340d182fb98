//! The exact solution of `x' = A x + b c + d` for a command that is a cubic polynomial.
//!
//! Its Taylor series is summed to rounding over steps that are short against the fastest mode. For
//! a step length that comes again, the series are summed once and kept as matrices.

use super::Command;
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
    #[inline]
    fn apply(&self, x: &[S; N]) -> [S; N] {
        std::array::from_fn(|i| {
            let products = self.a[i].iter().zip(x).map(|(a, x)| *a * *x);
            products.fold(S::constant(0.0), |sum, product| sum + product)
        })
    }

    /// `x` after `step`: `X_{k+1} = (A X_k + b q_k + d [k = 0]) step/(k + 1)`.
    fn solve(&self, x: &[S; N], q: &[S; 4], step: S, terms: usize) -> [S; N] {
        let mut sum = *x;
        let mut term = *x;
        let mut power = S::constant(1.0);
        for k in 0..terms {
            let factor = step * (1.0 / (k + 1) as f64);
            let mut next = self.apply(&term);
            for i in 0..N {
                if let Some(q) = q.get(k) {
                    next[i] = next[i] + self.b[i] * *q * power;
                }
                if k == 0 {
                    next[i] = next[i] + self.d[i];
                }
                next[i] = next[i] * factor;
                sum[i] = sum[i] + next[i];
            }
            power = power * step;
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

/// How a step length is known again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kept {
    /// It is not kept.
    No,
    /// By its length and by which way the delay moves its ends, -1, 0 or 1.
    As(i8),
}

/// Length of a part, which way the delay moves its ends, and how many parts there are.
type Key = (u64, i8, usize);

/// The solution over one step length.
#[derive(Clone, Copy)]
struct Transition<S, const N: usize> {
    key: Key,
    state: [[S; N]; N],
    command: [[S; N]; 4],
    constant: [S; N],
}

/// Transitions that are kept of a mode: even samples have one, with a delay three.
const MOST_KEPT: usize = 8;

/// The most of `step times fastest eigenvalue` within which no limit is passed unseen.
const LONGEST_PART: f64 = 1.0;

/// A model with an eigenvalue beyond this is none of a servo, rad/s: it would take a hundred steps
/// from sample to sample to follow it.
const FASTEST_RAD_S: f64 = 2e4;

/// A system with what has been computed of it.
pub struct Propagator<S, const N: usize> {
    pub system: System<S, N>,
    /// The same without derivatives.
    pub plain: System<f64, N>,
    fastest: f64,
    kept: Vec<Transition<S, N>>,
    oldest: usize,
}

impl<S: Scalar, const N: usize> Propagator<S, N> {
    pub fn new(system: System<S, N>) -> Self {
        Self {
            plain: system.without_derivatives(),
            fastest: system.fastest(),
            system,
            kept: Vec::new(),
            oldest: 0,
        }
    }

    /// Whether it is too fast to be followed, or no system at all.
    pub fn is_too_fast(&self) -> bool {
        self.fastest.is_nan() || self.fastest > FASTEST_RAD_S
    }

    /// Into how many parts a step is cut.
    #[inline]
    pub fn parts(&self, step_s: f64) -> usize {
        let parts = step_s * self.fastest / LONGEST_PART;
        // `as` takes NaN to 0 and saturates; a model so fast is at its steady state anyway.
        (parts.ceil() as usize).clamp(1, 100_000)
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

    /// The state after a step, from scratch.
    pub fn solve(&self, x: &[S; N], command: &Command<S>, step: S) -> [S; N] {
        let q = match command {
            Command::Constant(value) => {
                let zero = S::constant(0.0);
                [S::constant(*value), zero, zero, zero]
            }
            Command::Cubic(q) => *q,
        };
        self.system.solve(x, &q, step, self.terms(step.value()))
    }

    /// The same without derivatives.
    pub fn solve_plain(&self, x: &[f64; N], q: &[f64; 4], step_s: f64) -> [f64; N] {
        self.plain.solve(x, q, step_s, self.terms(step_s))
    }

    /// The state after a step, by what is kept for its length.
    #[inline]
    pub fn propagate(
        &mut self,
        x: &[S; N],
        command: &Command<S>,
        step: S,
        (kept, parts): (Kept, usize),
    ) -> [S; N] {
        let Kept::As(side) = kept else {
            return self.solve(x, command, step);
        };
        let key = (step.value().to_bits(), side, parts);
        let index = match self.kept.iter().position(|t| t.key == key) {
            Some(index) => index,
            None => self.keep(key, step),
        };
        self.kept[index].apply(x, command)
    }

    fn keep(&mut self, key: Key, step: S) -> usize {
        let transition = self.transition(key, step);
        if self.kept.len() < MOST_KEPT {
            self.kept.push(transition);
            return self.kept.len() - 1;
        }
        self.oldest = (self.oldest + 1) % MOST_KEPT;
        self.kept[self.oldest] = transition;
        self.oldest
    }

    fn transition(&self, key: Key, step: S) -> Transition<S, N> {
        let terms = self.terms(step.value());
        let (zero, one) = (S::constant(0.0), S::constant(1.0));
        let forced = System {
            d: [zero; N],
            ..self.system
        };
        let column = |j: usize| {
            let unit = std::array::from_fn(|i| if i == j { one } else { zero });
            forced.solve(&unit, &[zero; 4], step, terms)
        };
        let columns: [[S; N]; N] = std::array::from_fn(column);
        let moment = |j: usize| {
            let unit = std::array::from_fn(|i| if i == j { one } else { zero });
            forced.solve(&[zero; N], &unit, step, terms)
        };
        Transition {
            key,
            state: std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i])),
            command: std::array::from_fn(moment),
            constant: self.system.solve(&[zero; N], &[zero; 4], step, terms),
        }
    }
}

impl<S: Scalar, const N: usize> Transition<S, N> {
    #[inline]
    fn apply(&self, x: &[S; N], command: &Command<S>) -> [S; N] {
        std::array::from_fn(|i| {
            let mut sum = self.constant[i];
            for (state, x) in self.state[i].iter().zip(x) {
                sum = sum + *state * *x;
            }
            match command {
                Command::Constant(value) => sum + self.command[0][i] * *value,
                Command::Cubic(q) => {
                    for (moment, q) in self.command.iter().zip(q) {
                        sum = sum + moment[i] * *q;
                    }
                    sum
                }
            }
        })
    }
}
