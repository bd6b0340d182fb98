//! Finds clipped samples: the angle remains at an end of its range although the actuator should
//! move.

use std::ops::Range;

/// Consecutive samples at an end of the range.
#[derive(Debug, Clone, PartialEq)]
pub struct Clipped {
    /// Its samples.
    pub samples: Range<usize>,
    /// Their angle, deg.
    pub angle_deg: f64,
}

/// Least number of equal samples.
const FEWEST: usize = 5;
/// Arrival with more than this share of the fastest change is abrupt and not a settling.
const ABRUPT: f64 = 0.3;
/// Distance, as a share of its range, from which the command is beyond the end.
const BEYOND: f64 = 0.02;
/// Change, as a share of its range, from which the command moves further away.
const MOVING: f64 = 0.1;

/// Finds clipped samples: at the smallest or largest angle of all, with the command beyond it, and
/// either reached at full speed, or held while the command moves further away.
///
/// Neither applies to an actuator that settles on its command, stops short of it, or is held by
/// friction at a maximum.
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
        // Distance of the command beyond the end, as a share of its range.
        let beyond = |command: &f64| outward * (command - run[0]) / command_range;
        let count = commands.iter().filter(|c| beyond(c) > BEYOND).count();
        let before = samples.start.checked_sub(1).map(|i| angle_deg[i]);
        let arrival = before.map_or(0.0, |before| (run[0] - before).abs());
        // In the first half only: the command may return in the second.
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
