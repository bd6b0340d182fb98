//! Exact simulation of models that are linear between their limits.
//!
//! Such a model is a set of modes. Within a mode `x' = A x + b c + d`, the command `c` being a cubic
//! polynomial of time; a mode ends where an affine function of state and command, its face, falls
//! below zero. Each step is the exact solution (`linear`), each crossing of a face is found within
//! its step (`crossing`): no step length stands between the model and its answer. Since the
//! numbers may be [`Dual`](super::scalar::Dual), crossings included, the derivatives are those of
//! the exact solution too.

mod crossing;
mod drive;
mod ladder;
mod linear;
mod propagator;
mod runner;
mod transition;

pub use drive::{Steps, Watch, drive, drive_steps};
pub use linear::System;
pub use propagator::Kept;

use super::model::State;
use super::scalar::Scalar;

/// A boundary of a mode: inside, `row x + command c + constant >= 0`.
#[derive(Debug, Clone, Copy)]
pub struct Face<S, const N: usize> {
    /// Coefficients of the state.
    pub row: [S; N],
    /// Coefficient of the command.
    pub command: S,
    /// What is added.
    pub constant: S,
    /// The mode behind it.
    pub next: usize,
}

impl<S: Scalar, const N: usize> Face<S, N> {
    #[inline(always)]
    fn at(&self, x: &[S; N], command: S) -> S {
        let mut sum = self.constant + self.command * command;
        for (row, x) in self.row.iter().zip(x) {
            sum = sum + *row * *x;
        }
        sum
    }

    /// How fast its value changes.
    fn slope(&self, rates: &[S; N], command_rate: S) -> S {
        let mut slope = self.command * command_rate;
        for (row, rate) in self.row.iter().zip(rates) {
            slope = slope + *row * *rate;
        }
        slope
    }

    fn without_derivatives(&self) -> Face<f64, N> {
        Face {
            row: values(&self.row),
            command: self.command.value(),
            constant: self.constant.value(),
            next: self.next,
        }
    }
}

/// A model that is linear between its limits, with `N` states.
pub trait Flow<S: Scalar, const N: usize> {
    /// How many modes there are; they are numbered from 0.
    const MODES: usize;

    /// The equations in a mode.
    fn system(&self, mode: usize) -> System<S, N>;

    /// The boundaries of a mode.
    fn faces(&self, mode: usize) -> Vec<Face<S, N>>;

    /// The mode of a state under a command, where none is known from before.
    fn mode_at(&self, x: &[f64; N], command: f64) -> usize;

    /// What entering a mode does to the state.
    fn enter(&self, _mode: usize, _x: &mut [S; N]) {}

    /// Angle, rate and limit that are seen.
    fn seen(&self, mode: usize, x: &[S; N], command: f64) -> (S, f64, State);
}

/// Coefficients of a command in the time from the start of a step.
#[derive(Clone, Copy)]
pub enum Command<S> {
    /// It stands still.
    Constant(f64),
    /// A cubic polynomial, lowest power first.
    Cubic([S; 4]),
}

impl<S: Scalar> Command<S> {
    /// As it is `time` later.
    #[inline]
    pub fn later(&self, u: S) -> Self {
        let Self::Cubic([q0, q1, q2, q3]) = *self else {
            return *self;
        };
        let q3_u = q3 * u;
        Self::Cubic([
            q0 + u * (q1 + u * (q2 + q3_u)),
            q1 + u * (q2 * 2.0 + q3_u * 3.0),
            q2 + q3_u * 3.0,
            q3,
        ])
    }

    fn without_derivatives(&self) -> Command<f64> {
        match self {
            Self::Constant(value) => Command::Constant(*value),
            Self::Cubic(q) => Command::Cubic(q.map(S::value)),
        }
    }

    /// Its value so many seconds later.
    #[inline]
    pub fn value_after(&self, u: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Cubic(q) => {
                let [q0, q1, q2, q3] = q.map(S::value);
                q0 + u * (q1 + u * (q2 + u * q3))
            }
        }
    }
}

impl Command<f64> {
    /// Its value and slope so many seconds later.
    fn at(&self, u: f64) -> (f64, f64) {
        match self {
            Self::Constant(value) => (*value, 0.0),
            Self::Cubic([q0, q1, q2, q3]) => (
                q0 + u * (q1 + u * (q2 + u * q3)),
                q1 + u * (2.0 * q2 + u * 3.0 * q3),
            ),
        }
    }
}

#[inline(always)]
fn values<S: Scalar, const N: usize>(x: &[S; N]) -> [f64; N] {
    let mut values = [0.0; N];
    for (value, x) in values.iter_mut().zip(x) {
        *value = x.value();
    }
    values
}
