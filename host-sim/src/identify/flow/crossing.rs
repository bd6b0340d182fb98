//! Where within a step a mode is left.

use super::linear::Propagator;
use super::{Command, Face, Mode, SLACK, values};
use crate::identify::scalar::Scalar;

/// Halvings and secants after which a crossing is known to rounding.
const MOST_TRIALS: usize = 60;

/// The time of the first crossing within a step that ends outside, and the mode behind it. The
/// time depends on the parameters as the crossing does.
pub fn first<S: Scalar, const N: usize>(
    mode: &Mode<S, N>,
    x: &[S; N],
    command: &Command<S>,
    step_s: f64,
) -> (S, usize) {
    let plain = values(x);
    let q = match command {
        Command::Constant(value) => [*value, 0.0, 0.0, 0.0],
        Command::Cubic(q) => q.map(S::value),
    };
    let end = mode.linear.solve_plain(&plain, &q, step_s);
    let end_command = command.value_after(step_s);
    let mut earliest: Option<(f64, &Face<S, N>)> = None;
    for face in &mode.faces {
        if face.value(&end, end_command) >= -SLACK {
            continue;
        }
        let height = |time_s: f64| {
            let there = mode.linear.solve_plain(&plain, &q, time_s);
            face.value(&there, command.value_after(time_s))
        };
        let time_s = root(height, step_s);
        if earliest.is_none_or(|(before, _)| time_s < before) {
            earliest = Some((time_s, face));
        }
    }
    let Some((time_s, face)) = earliest else {
        // Rounding: kept and plain solution lie on both sides of the slack.
        let next = mode.faces.iter().min_by(|a, b| {
            let height = |face: &Face<S, N>| face.value(&end, end_command);
            height(a).total_cmp(&height(b))
        });
        return (S::constant(step_s), next.map_or(0, |face| face.next));
    };
    (exact(&mode.linear, face, x, command, time_s), face.next)
}

/// The zero of a function that is not negative at 0 and negative at `end` (Illinois method, Dowell
/// and Jarratt, BIT 11, 1971).
fn root(height: impl Fn(f64) -> f64, end: f64) -> f64 {
    let (mut left, mut right) = (0.0, end);
    let (mut above, mut below) = (height(left), height(right));
    if above <= 0.0 {
        return 0.0;
    }
    let mut last_side = 0;
    for _ in 0..MOST_TRIALS {
        let middle = (left * below - right * above) / (below - above);
        let value = height(middle);
        if value.abs() <= 1e-3 * SLACK || right - left <= 1e-15 * end {
            return middle;
        }
        if value > 0.0 {
            (left, above) = (middle, value);
            below *= if last_side == 1 { 0.5 } else { 1.0 };
            last_side = 1;
        } else {
            (right, below) = (middle, value);
            above *= if last_side == -1 { 0.5 } else { 1.0 };
            last_side = -1;
        }
    }
    right
}

/// One step of Newton's method on a root: the value stays, the derivatives come in (implicit
/// function theorem).
fn exact<S: Scalar, const N: usize>(
    linear: &Propagator<S, N>,
    face: &Face<S, N>,
    x: &[S; N],
    command: &Command<S>,
    time_s: f64,
) -> S {
    let time = S::constant(time_s);
    let there = linear.solve(x, command, time);
    let (level, slope) = match command.later(time) {
        Command::Constant(value) => (S::constant(value), 0.0),
        Command::Cubic(q) => (q[0], q[1].value()),
    };
    let height = face.at(&there, level);
    let (plain, system) = (values(&there), &linear.plain);
    let mut fall = face.command.value() * slope;
    for i in 0..N {
        let a_x: f64 = (0..N).map(|j| system.a[i][j] * plain[j]).sum();
        fall += face.row[i].value() * (a_x + system.b[i] * level.value() + system.d[i]);
    }
    // A face that is only touched is crossed at no definite time.
    if fall.abs() < 1e-9 || time_s == 0.0 {
        return time;
    }
    time + height * (-1.0 / fall)
}
