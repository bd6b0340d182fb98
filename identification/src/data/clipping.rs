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
/// A command beyond the end by this share of its range asks for an angle there.
const BEYOND: f64 = 0.02;
/// A command that goes on by this share of its range, away from the end, asks for motion.
const MOVING: f64 = 0.1;

/// Finds the stretches: at the very least or greatest angle of all, with the command beyond it, and
/// either reached at full speed and held at once, or held while the command goes on further away.
///
/// An actuator that settles on its command, that stands short of it or that friction holds at a
/// crest does none of that.
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
        let outward = if run[0] == greatest { 1.0 } else { -1.0 };
        let commands = command_deg.get(samples.clone()).unwrap_or(&[]);
        // How far the command is beyond the end, as a share of its range.
        let beyond = |command: &f64| outward * (command - run[0]) / command_range;
        let count = commands.iter().filter(|c| beyond(c) > BEYOND).count();
        let before = samples.start.checked_sub(1).map(|i| angle_deg[i]);
        let arrival = before.map_or(0.0, |before| (run[0] - before).abs());
        // Until its middle: at its end the command may have turned already.
        let first_half = commands.get(..=run.len() / 2).unwrap_or(&[]);
        let farthest = first_half
            .iter()
            .map(beyond)
            .fold(f64::NEG_INFINITY, f64::max);
        let goes_on = first_half
            .first()
            .is_some_and(|c| farthest - beyond(c) > MOVING);
        if count * 2 > run.len() && (arrival > ABRUPT * fastest || goes_on) {
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
