//! Resamples recordings on an even grid, in segments without gaps.

use crate::{
    recording::{Hold, Recording},
    statistics::slots::median_step_of_s,
};

/// Multiple of the median step from which a gap separates two segments.
const GAP_STEPS: f64 = 5.0;
/// Largest number of grid points as a multiple of the samples.
const MOST_GROWTH: f64 = 8.0;

/// A segment of a recording at even instants.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// Commanded angle, deg.
    pub command_deg: Vec<f64>,
    /// Measured angle, deg.
    pub angle_deg: Vec<f64>,
}

/// The common step of all recordings: the longest of their median steps, s.
pub fn common_step_s(recordings: &[&Recording]) -> Option<f64> {
    let step = |r: &&Recording| median_step_of_s(&r.time_s, &r.angle_deg);
    let steps = recordings.iter().filter_map(step);
    steps.max_by(f64::total_cmp)
}

/// Whether the command is a zero-order hold; where that is not known, a command that is constant in
/// one of five steps is assumed to be one.
pub fn is_held(recording: &Recording) -> bool {
    match recording.hold {
        Hold::Zero => true,
        Hold::Smooth => false,
        Hold::Auto => {
            let steps = recording.command_deg.windows(2);
            steps.filter(|c| c[0] == c[1]).count() * 5 >= recording.len()
        }
    }
}

/// The segments of a recording in steps of `step_s`: the command held or interpolated linearly, the
/// angle interpolated linearly. Missing angles that exceed a gap also separate segments.
pub fn stretches(recording: &Recording, step_s: f64) -> Vec<Stretch> {
    let held = is_held(recording);
    let complete = |&i: &usize| recording.angle_deg[i].is_finite();
    let present: Vec<usize> = (0..recording.len()).filter(complete).collect();
    let usual_s = median_step_of_s(&recording.time_s, &recording.angle_deg).unwrap_or(step_s);
    let time = |i: usize| recording.time_s[i];
    let is_gap = |a: &usize, b: &usize| time(*b) - time(*a) > GAP_STEPS * usual_s;
    let mut command = Vec::with_capacity(recording.len());
    let mut last = f64::NAN;
    for &value in &recording.command_deg {
        last = if value.is_finite() { value } else { last };
        command.push(last);
    }
    let stretch = |samples: &[usize]| resampled(recording, &command, samples, step_s, held);
    let runs = present.chunk_by(|a, b| !is_gap(a, b));
    runs.filter_map(stretch).collect()
}

/// The samples of a segment on a grid that begins with its first.
fn resampled(
    recording: &Recording,
    command: &[f64],
    samples: &[usize],
    step_s: f64,
    held: bool,
) -> Option<Stretch> {
    let (first, last) = (*samples.first()?, *samples.last()?);
    let start_s = recording.time_s[first];
    // With a tolerance, so that the grid includes the last sample of an even recording.
    let steps = ((recording.time_s[last] - start_s) / step_s + 1e-6).floor();
    if steps.is_nan() || steps > MOST_GROWTH * samples.len() as f64 || !command[first].is_finite() {
        return None;
    }
    let mut stretch = Stretch {
        command_deg: Vec::with_capacity(steps as usize + 1),
        angle_deg: Vec::with_capacity(steps as usize + 1),
    };
    let mut at = 0;
    for step in 0..=steps as usize {
        let t = start_s + step as f64 * step_s;
        while at + 2 < samples.len() && recording.time_s[samples[at + 1]] <= t + 1e-6 * step_s {
            at += 1;
        }
        let (a, b) = (samples[at], *samples.get(at + 1).unwrap_or(&samples[at]));
        let (from, to) = (recording.time_s[a], recording.time_s[b]);
        let share = if to > from {
            (t - from) / (to - from)
        } else {
            0.0
        };
        let between = |y: &[f64]| y[a] + (y[b] - y[a]) * share;
        stretch.angle_deg.push(between(&recording.angle_deg));
        let at_end = share >= 1.0 - 1e-6;
        stretch.command_deg.push(match held {
            true if at_end => command[b],
            true => command[a],
            false => between(command),
        });
    }
    Some(stretch)
}
