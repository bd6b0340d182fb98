//! Stretches in which the angle stands at the end of its range although the actuator should move.

use std::ops::Range;

/// A stretch at an end of the range.
#[derive(Debug, Clone, PartialEq)]
pub struct Clipped {
    /// Its samples.
    pub samples: Range<usize>,
    /// The angle that they have, deg.
    pub angle_deg: f64,
}

/// Fewer equal samples are chance.
const FEWEST: usize = 5;
/// Arriving at the end with this share of the fastest change of all is no settling.
const ABRUPT: f64 = 0.3;
/// A command that changes by this share of its range while the angle stands still asks for motion.
const MOVING: f64 = 0.1;

/// Finds the stretches: at the very least or greatest angle of all, and either reached at full speed
/// and held at once, or held while the command goes on moving beyond it.
pub fn find(command_deg: &[f64], angle_deg: &[f64]) -> Vec<Clipped> {
    let Some((least, greatest)) = range(angle_deg) else {
        return Vec::new();
    };
    let command_range = range(command_deg).map_or(0.0, |(low, high)| high - low);
    let changes = angle_deg.windows(2).map(|w| (w[1] - w[0]).abs());
    let fastest = changes.filter(|c| c.is_finite()).fold(0.0, f64::max);
    let mut found = Vec::new();
    let mut start = 0;
    for run in angle_deg.chunk_by(|a, b| a == b) {
        let samples = start..start + run.len();
        start = samples.end;
        let at_end = run[0] == least || run[0] == greatest;
        if run.len() < FEWEST || !at_end || least == greatest {
            continue;
        }
        let before = samples.start.checked_sub(1).map(|i| angle_deg[i]);
        let arrival = before.map_or(0.0, |before| (run[0] - before).abs());
        let commands = command_deg.get(samples.clone()).unwrap_or(&[]);
        let moved = range(commands).map_or(0.0, |(low, high)| high - low);
        let is_beyond = |c: &&f64| {
            if run[0] == greatest {
                **c > greatest
            } else {
                **c < least
            }
        };
        let beyond = commands.iter().filter(is_beyond).count();
        let held_back = moved > MOVING * command_range && beyond * 2 > commands.len();
        if arrival > ABRUPT * fastest || held_back {
            let angle_deg = run[0];
            found.push(Clipped { samples, angle_deg });
        }
    }
    found
}

fn range(values: &[f64]) -> Option<(f64, f64)> {
    let numbers = values.iter().copied().filter(|v| v.is_finite());
    numbers.fold(None, |range, value| match range {
        None => Some((value, value)),
        Some((low, high)) => Some((low.min(value), high.max(value))),
    })
}
