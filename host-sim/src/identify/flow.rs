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
mod linear;

pub use drive::{Steps, drive, drive_steps};
pub use linear::{Kept, System};

use self::linear::Propagator;
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
    #[inline]
    fn at(&self, x: &[S; N], command: S) -> S {
        let mut sum = self.constant + self.command * command;
        for (row, x) in self.row.iter().zip(x) {
            sum = sum + *row * *x;
        }
        sum
    }

    /// The same without derivatives.
    #[inline]
    fn value(&self, x: &[f64; N], command: f64) -> f64 {
        let mut sum = self.constant.value() + self.command.value() * command;
        for (row, x) in self.row.iter().zip(x) {
            sum += row.value() * x;
        }
        sum
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

/// By how much a face may be below zero without being crossed: rounding of values of 1e3.
const SLACK: f64 = 1e-9;

/// Crossings within one step after which the mode is decided anew.
const MOST_CROSSINGS: usize = 16;

/// All that is known of a mode.
struct Mode<S, const N: usize> {
    linear: Propagator<S, N>,
    faces: Vec<Face<S, N>>,
}

/// A model in motion.
struct Runner<'a, F, S, const N: usize> {
    flow: &'a F,
    modes: Vec<Option<Box<Mode<S, N>>>>,
    mode: usize,
    x: [S; N],
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
    pub fn later(self, u: S) -> Self {
        let Self::Cubic([q0, q1, q2, q3]) = self else {
            return self;
        };
        let q3_u = q3 * u;
        Self::Cubic([
            q0 + u * (q1 + u * (q2 + q3_u)),
            q1 + u * (q2 * 2.0 + q3_u * 3.0),
            q2 + q3_u * 3.0,
            q3,
        ])
    }

    #[inline]
    /// Its value so many seconds later.
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

fn values<S: Scalar, const N: usize>(x: &[S; N]) -> [f64; N] {
    std::array::from_fn(|i| x[i].value())
}

impl<'a, S: Scalar, const N: usize, F: Flow<S, N>> Runner<'a, F, S, N> {
    fn new(flow: &'a F, x: [S; N], command: f64) -> Self {
        let mut runner = Self {
            flow,
            modes: (0..F::MODES).map(|_| None).collect(),
            mode: 0,
            x,
        };
        runner.decide(command);
        runner
    }

    /// Finds the mode from state and command alone, as after a jump of the command.
    fn decide(&mut self, command: f64) {
        self.change(self.flow.mode_at(&values(&self.x), command));
    }

    fn change(&mut self, mode: usize) {
        self.mode = mode;
        self.flow.enter(mode, &mut self.x);
        let flow = self.flow;
        self.modes[mode].get_or_insert_with(|| {
            Box::new(Mode {
                linear: Propagator::new(flow.system(mode)),
                faces: flow.faces(mode),
            })
        });
    }

    /// Moves through `step`; `kept` is how to keep what is computed for its length.
    fn advance(&mut self, step: S, kept: Kept, command: Command<S>) {
        let (mut left, mut kept, mut command) = (step, kept, command);
        for _ in 0..MOST_CROSSINGS {
            let Some(crossing) = self.advance_inside(left, kept, &mut command) else {
                return;
            };
            left = crossing.left;
            kept = Kept::No;
            self.change(crossing.next);
        }
        // A mode that is left as soon as it is entered: what state and command say decides.
        self.decide(command.value_after(0.0));
        self.advance_inside(left, Kept::No, &mut command);
    }

    /// Moves until the end of `step` or the first crossing, whichever comes first, and takes the
    /// command along.
    fn advance_inside(
        &mut self,
        step: S,
        kept: Kept,
        command: &mut Command<S>,
    ) -> Option<Crossing<S>> {
        let mode = self.modes[self.mode].as_deref_mut()?;
        if mode.linear.is_too_fast() {
            self.x = [S::constant(f64::NAN); N];
            return None;
        }
        let parts = mode.linear.parts(step.value());
        let part = if parts == 1 {
            step
        } else {
            step * (1.0 / parts as f64)
        };
        for done in 0..parts {
            let end = mode.linear.propagate(&self.x, command, part, (kept, parts));
            let end_values = values(&end);
            let end_command = command.value_after(part.value());
            let is_outside = |face: &Face<S, N>| face.value(&end_values, end_command) < -SLACK;
            // NaN is not outside: no crossing is looked for there.
            if mode.faces.iter().any(is_outside) {
                let (at, next) = crossing::first(mode, &self.x, command, part.value());
                self.x = mode.linear.solve(&self.x, command, at);
                *command = command.later(at);
                let left = part * (parts - done) as f64 - at;
                return Some(Crossing { left, next });
            }
            self.x = end;
            if done + 1 < parts {
                *command = command.later(part);
            }
        }
        None
    }
}

/// A mode that was left within a step.
struct Crossing<S> {
    /// What is left of the step.
    left: S,
    /// The mode that was entered.
    next: usize,
}
