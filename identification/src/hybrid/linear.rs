//! The exact solution of `x' = A x + b c + d` for a command that is a cubic polynomial.
//!
//! Its Taylor series is summed to rounding, over steps that are short against the fastest
//! eigenvalue.

use super::Command;
use crate::scalar::Scalar;

/// The equations of a mode.
#[derive(Debug, Clone, Copy)]
pub struct LinearSystem<S, const N: usize> {
    /// `A`, by rows.
    pub a: [[S; N]; N],
    /// `b`.
    pub b: [S; N],
    /// `d`.
    pub d: [S; N],
}

impl<S: Scalar, const N: usize> LinearSystem<S, N> {
    /// The same without derivatives.
    pub fn without_derivatives(&self) -> LinearSystem<f64, N> {
        LinearSystem {
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

    /// The series that begins with `x`; `force` adds the inhomogeneous terms.
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

    /// An upper bound of the spectral radius of `A`: the eighth root of the norm of `A^8`.
    pub fn fastest(&self) -> f64 {
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

/// Adds `factor` times `more`.
#[inline(always)]
pub fn add<S: Scalar, const N: usize>(sums: &mut [S; N], more: &[S; N], factor: S) {
    for (sum, more) in sums.iter_mut().zip(more) {
        *sum = *sum + *more * factor;
    }
}
