//! Where within a step a mode is left.

use super::propagator::Propagator;
use super::runner::{Mode, SLACK};
use super::{Command, Face, values};
use crate::scalar::Scalar;

/// Steps and halvings after which a crossing is known to rounding.
const MOST_TRIALS: usize = 60;

/// The first crossing of a face within a step.
pub struct Crossing<S, const N: usize> {
    /// When: it depends on the parameters as the crossing does.
    pub time: S,
    /// The state there.
    pub x: [S; N],
    /// The mode behind the face.
    pub next: usize,
}

/// The first crossing within a step that ends outside.
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
    for (index, edge) in mode.edges.iter().enumerate() {
        if edge.at(&end, end_command) >= -SLACK {
            continue;
        }
        // What lies on the face already crosses it now.
        let time_s = if edge.at(&plain, command.value_after(0.0)) <= 0.0 {
            0.0
        } else {
            let height = |time_s: f64| height_of(mode, edge, &at(time_s), plain_command.at(time_s));
            root(height, step_s)
        };
        if earliest.is_none_or(|(before, _)| time_s < before) {
            earliest = Some((time_s, index));
        }
    }
    match earliest {
        Some((time_s, index)) => exact(&mode.linear, &mode.faces[index], x, command, time_s),
        None => {
            // Rounding: kept and plain solution lie on both sides of the slack.
            let height = |edge: &&Face<f64, N>| edge.at(&end, end_command);
            let lowest = mode
                .edges
                .iter()
                .min_by(|a, b| height(a).total_cmp(&height(b)));
            Crossing {
                time: step,
                x: mode.linear.solve(x, command, step),
                next: lowest.map_or(0, |edge| edge.next),
            }
        }
    }
}

/// How far a state is above an edge under a command of this value and slope, and how fast that
/// changes.
fn height_of<S: Scalar, const N: usize>(
    mode: &Mode<S, N>,
    edge: &Face<f64, N>,
    x: &[f64; N],
    (command, slope): (f64, f64),
) -> (f64, f64) {
    let rates = mode.linear.series.plain.rates(x, command);
    (edge.at(x, command), edge.slope(&rates, slope))
}

/// The zero of a function that is above zero at 0 and below it at `end`, by its values and slopes
/// (Newton's method, kept within brackets: Press et al., Numerical Recipes, 3rd ed., section 9.4).
fn root(height: impl Fn(f64) -> (f64, f64), end: f64) -> f64 {
    let (mut left, mut right, mut time) = (0.0, end, end);
    for _ in 0..MOST_TRIALS {
        let (value, slope) = height(time);
        if value.abs() <= 1e-3 * SLACK || right - left <= 1e-15 * end {
            break;
        }
        if value > 0.0 {
            left = time;
        } else {
            right = time;
        }
        let next = time - value / slope;
        // Written so that NaN fails.
        let is_within = next > left && next < right;
        time = if is_within {
            next
        } else {
            0.5 * (left + right)
        };
    }
    time
}

/// One step of Newton's method on a root: the value stays, the derivatives come in (implicit
/// function theorem).
fn exact<S: Scalar, const N: usize>(
    linear: &Propagator<S, N>,
    face: &Face<S, N>,
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
    let height = face.at(&there, level);
    let (plain, plain_command) = (values(&there), command.without_derivatives().at(time_s));
    let rates = linear.series.plain.rates(&plain, plain_command.0);
    let fall = face.without_derivatives().slope(&rates, plain_command.1);
    // A face that is only touched is crossed at no definite time.
    let is_touched = fall.abs() < 1e-9 || time_s == 0.0;
    let later = if is_touched {
        S::constant(0.0)
    } else {
        height * (-1.0 / fall)
    };
    // So little later that its square is lost in rounding.
    for i in 0..N {
        there[i] = there[i] + later * rates[i];
    }
    Crossing {
        time: time + later,
        x: there,
        next: face.next,
    }
}
