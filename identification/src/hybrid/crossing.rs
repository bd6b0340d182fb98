//! Locates the event within a step that leaves its mode.

use super::propagator::Propagator;
use super::simulator::{Mode, TOLERANCE};
use super::{Command, Guard, values};
use crate::scalar::Scalar;

/// Iterations after which a crossing is known to rounding.
const MOST_ITERATIONS: usize = 60;

/// The first crossing of a guard within a step.
pub struct Crossing<S, const N: usize> {
    /// Its time, which depends on the parameters.
    pub time: S,
    /// The state there.
    pub x: [S; N],
    /// The mode that is entered.
    pub next: usize,
}

/// The first crossing within a step that ends outside the mode.
pub fn first<S: Scalar, const N: usize>(
    mode: &Mode<S, N>,
    x: &[S; N],
    command: &Command<S>,
    step: S,
) -> Crossing<S, N> {
    let (plain, plain_command, step_s) = (values(x), command.without_derivatives(), step.value());
    let at = |time_s: f64| mode.linear.solve_plain(&plain, &plain_command, time_s);
    let (end, end_command) = (at(step_s), command.value_after(step_s));
    let mut earliest: Option<(f64, usize)> = None;
    for (index, guard) in mode.plain_guards.iter().enumerate() {
        if guard.at(&end, end_command) >= -TOLERANCE {
            continue;
        }
        // A state on the guard crosses it at once.
        let time_s = if guard.at(&plain, command.value_after(0.0)) <= 0.0 {
            0.0
        } else {
            let height =
                |time_s: f64| height_of(mode, guard, &at(time_s), plain_command.at(time_s));
            root(height, step_s)
        };
        if earliest.is_none_or(|(before, _)| time_s < before) {
            earliest = Some((time_s, index));
        }
    }
    match earliest {
        Some((time_s, index)) => refined(&mode.linear, &mode.guards[index], x, command, time_s),
        None => {
            // Rounding: the cached and the uncached solution lie on both sides of the tolerance.
            let height = |guard: &&Guard<f64, N>| guard.at(&end, end_command);
            let lowest = mode
                .plain_guards
                .iter()
                .min_by(|a, b| height(a).total_cmp(&height(b)));
            Crossing {
                time: step,
                x: mode.linear.solve(x, command, step),
                next: lowest.map_or(0, |guard| guard.next),
            }
        }
    }
}

/// The value of a guard and its time derivative, for a command of this value and slope.
fn height_of<S: Scalar, const N: usize>(
    mode: &Mode<S, N>,
    guard: &Guard<f64, N>,
    x: &[f64; N],
    (command, slope): (f64, f64),
) -> (f64, f64) {
    let rates = mode.linear.series.plain.rates(x, command);
    (guard.at(x, command), guard.slope(&rates, slope))
}

/// The zero of a function that is positive at 0 and negative at `end`, from its values and slopes
/// (Newton's method within brackets: Press et al., Numerical Recipes, 3rd ed., section 9.4).
fn root(height: impl Fn(f64) -> (f64, f64), end: f64) -> f64 {
    let (mut left, mut right, mut time) = (0.0, end, end);
    for _ in 0..MOST_ITERATIONS {
        let (value, slope) = height(time);
        if value.abs() <= 1e-3 * TOLERANCE || right - left <= 1e-15 * end {
            break;
        }
        if value > 0.0 {
            left = time;
        } else {
            right = time;
        }
        let next = time - value / slope;
        // False for NaN.
        let is_within = next > left && next < right;
        time = if is_within {
            next
        } else {
            0.5 * (left + right)
        };
    }
    time
}

/// One step of Newton's method from a root: it does not change the value and adds the derivatives
/// (implicit function theorem).
fn refined<S: Scalar, const N: usize>(
    linear: &Propagator<S, N>,
    guard: &Guard<S, N>,
    x: &[S; N],
    command: &Command<S>,
    time_s: f64,
) -> Crossing<S, N> {
    let time = S::constant(time_s);
    let mut there = linear.solve(x, command, time);
    let level = match command.later(time) {
        Command::Constant(value) => S::constant(value),
        Command::Cubic(q) => q[0],
    };
    let height = guard.at(&there, level);
    let (plain, plain_command) = (values(&there), command.without_derivatives().at(time_s));
    let rates = linear.series.plain.rates(&plain, plain_command.0);
    let fall = guard.without_derivatives().slope(&rates, plain_command.1);
    // A guard that is only touched has no defined crossing time.
    let is_touched = fall.abs() < 1e-9 || time_s == 0.0;
    let later = if is_touched {
        S::constant(0.0)
    } else {
        height * (-1.0 / fall)
    };
    // The correction is so small that its square is below rounding.
    for i in 0..N {
        there[i] = there[i] + later * rates[i];
    }
    Crossing {
        time: time + later,
        x: there,
        next: guard.next,
    }
}
