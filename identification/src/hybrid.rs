//! Exact simulation of hybrid systems: models that are linear between their limits.
//!
//! Such a model is a set of modes. Within a mode `x' = A x + b c + d`, the command `c` being a
//! cubic polynomial of time; a mode ends where an affine function of state and command, its guard,
//! falls below zero. Each step is the exact solution (`linear`), and each event (a guard that
//! crosses zero) is located within its step (`crossing`): the result does not depend on the step
//! length. The numbers may be [`Dual`](super::scalar::Dual), including the event times, so that the
//! sensitivities are exact as well.

mod crossing;
mod doubling;
mod linear;
mod propagator;
mod simulate;
mod simulator;
mod transition;

pub use linear::LinearSystem;
pub use propagator::Caching;
pub use simulate::{Output, Stepper, simulate, simulate_steps};

use super::model::ActiveLimit;
use super::scalar::Scalar;

/// A guard of a mode: inside the mode, `row x + command c + constant >= 0`.
#[derive(Debug, Clone, Copy)]
pub struct Guard<S, const N: usize> {
    /// Coefficients of the state.
    pub row: [S; N],
    /// Coefficient of the command.
    pub command: S,
    /// The constant term.
    pub constant: S,
    /// The mode that is entered when it falls below zero.
    pub next: usize,
}

impl<S: Scalar, const N: usize> Guard<S, N> {
    #[inline(always)]
    fn at(&self, x: &[S; N], command: S) -> S {
        let mut sum = self.constant + self.command * command;
        for (row, x) in self.row.iter().zip(x) {
            sum = sum + *row * *x;
        }
        sum
    }

    /// The time derivative of its value.
    fn slope(&self, rates: &[S; N], command_rate: S) -> S {
        let mut slope = self.command * command_rate;
        for (row, rate) in self.row.iter().zip(rates) {
            slope = slope + *row * *rate;
        }
        slope
    }

    fn without_derivatives(&self) -> Guard<f64, N> {
        Guard {
            row: values(&self.row),
            command: self.command.value(),
            constant: self.constant.value(),
            next: self.next,
        }
    }
}

/// A hybrid system with `N` states that is linear in each mode.
pub trait HybridModel<S: Scalar, const N: usize> {
    /// The number of modes, which are numbered from 0.
    const MODES: usize;

    /// The equations in a mode.
    fn system(&self, mode: usize) -> LinearSystem<S, N>;

    /// The guards of a mode.
    fn guards(&self, mode: usize) -> Vec<Guard<S, N>>;

    /// The mode of a state under a command, independent of the previous mode.
    fn mode_at(&self, x: &[f64; N], command: f64) -> usize;

    /// The reset map: how entering a mode changes the state.
    fn reset(&self, _mode: usize, _x: &mut [S; N]) {}

    /// Angle, rate and active limit.
    fn output(&self, mode: usize, x: &[S; N], command: f64) -> (S, f64, ActiveLimit);
}

/// A command as a function of the time since the start of a step.
#[derive(Clone, Copy)]
pub enum Command<S> {
    /// A constant command.
    Constant(f64),
    /// A cubic polynomial, lowest power first.
    Cubic([S; 4]),
}

impl<S: Scalar> Command<S> {
    /// The same with a time origin that is `u` later.
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

    /// Its value `u` seconds later.
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
    /// Its value and slope `u` seconds later.
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
