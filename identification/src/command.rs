//! A sampled command as a function of time: cubic polynomials from sample to sample.
//!
//! A recording does not contain the command between two samples. A step takes place at the sample
//! with the new value; a chirp is a smooth curve through the samples. The wrong assumption causes
//! an error of half a sample of delay.

mod spline;

use super::recording::Hold;

/// A segment of the command: `q0 + q1 u + q2 u^2 + q3 u^3`, `u` in s from its start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Its start after the first sample, ns.
    pub start_ns: i64,
    /// Its coefficients.
    pub q: [f64; 4],
    /// Whether only `q0` is not zero.
    pub is_constant: bool,
    /// Whether the command jumps at its start.
    pub jumps: bool,
    /// The number of the independent variable that a constant level is, in derivatives by the
    /// command.
    pub variable: Option<usize>,
}

impl Segment {
    /// A level from this instant on, to which the command jumps.
    pub fn constant(start_ns: i64, value: f64) -> Self {
        Self {
            start_ns,
            q: [value, 0.0, 0.0, 0.0],
            is_constant: true,
            jumps: true,
            variable: None,
        }
    }
}

impl Segment {
    /// The command `u` seconds after its start.
    #[inline]
    pub fn after(&self, u: f64) -> f64 {
        let [q0, q1, q2, q3] = self.q;
        q0 + u * (q1 + u * (q2 + u * q3))
    }
}

/// Evaluates a command at increasing instants.
#[derive(Debug, Clone)]
pub struct Reader<'a> {
    segments: &'a [Segment],
    index: usize,
}

impl<'a> Reader<'a> {
    /// A reader of at least one segment.
    pub fn new(segments: &'a [Segment]) -> Self {
        Self { segments, index: 0 }
    }

    /// The command at an instant that is not before the previous one.
    pub fn at(&mut self, time_ns: i64) -> f64 {
        while self
            .segments
            .get(self.index + 1)
            .is_some_and(|s| s.start_ns <= time_ns)
        {
            self.index += 1;
        }
        let segment = &self.segments[self.index];
        segment.after((time_ns - segment.start_ns).max(0) as f64 * 1e-9)
    }
}

/// The command within the interval that follows a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Interval {
    Held,
    Smooth,
}

/// A command with at most this number of levels is a zero-order hold.
const FEW_LEVELS: usize = 24;

/// The command through these samples, with instants relative to the first. A missing value repeats
/// the previous one.
pub fn segments(time_ns: &[i64], command: &[f64], hold: Hold) -> Vec<Segment> {
    let values = filled(command);
    let kinds = intervals(&values, hold);
    let mut segments: Vec<Segment> = Vec::new();
    let mut i = 0;
    while i < values.len() {
        if kinds.get(i) != Some(&Interval::Smooth) {
            let last = segments.last().map(|s| (s.is_constant, s.q[0]));
            if last != Some((true, values[i])) {
                segments.push(Segment::constant(time_ns[i], values[i]));
            }
            i += 1;
            continue;
        }
        let smooth = kinds[i..].iter().take_while(|k| **k == Interval::Smooth);
        let end = i + smooth.count();
        spline::append(&mut segments, &time_ns[i..=end], &values[i..=end]);
        i = end;
        if i + 1 == values.len() {
            break;
        }
    }
    mark_jumps(&mut segments);
    segments
}

/// The values with each missing one replaced by the previous one, or by the first available one.
fn filled(command: &[f64]) -> Vec<f64> {
    let first = command.iter().copied().find(|c| !c.is_nan());
    let mut last = first.unwrap_or(0.0);
    let next = |value: &f64| {
        if !value.is_nan() {
            last = *value;
        }
        last
    };
    command.iter().map(next).collect()
}

/// The kind of each interval between two samples.
fn intervals(values: &[f64], hold: Hold) -> Vec<Interval> {
    let moves: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if hold == Hold::Zero || (hold == Hold::Auto && has_few_levels(values)) {
        return vec![Interval::Held; moves.len()];
    }
    let size = |i: usize| moves.get(i).map_or(0.0, |m| m.abs());
    let before = |i: usize| i.checked_sub(1).map_or(0.0, size);
    // An isolated change is a step; a slope continues on at least one side.
    let is_step = |i: usize| hold == Hold::Auto && before(i).max(size(i + 1)) < size(i) / 4.0;
    let is_slope = |i: usize| size(i) > 0.0 && !is_step(i);
    let kind = |i: usize| {
        // The two samples next to the maximum of a curve may be equal.
        let is_top = size(i) == 0.0 && i > 0 && is_slope(i - 1) && is_slope(i + 1);
        if is_slope(i) || is_top {
            Interval::Smooth
        } else {
            Interval::Held
        }
    };
    (0..moves.len()).map(kind).collect()
}

fn has_few_levels(values: &[f64]) -> bool {
    let mut levels: Vec<f64> = Vec::with_capacity(FEW_LEVELS);
    for value in values {
        if !levels.contains(value) {
            if levels.len() == FEW_LEVELS.min(values.len() / 4) {
                return false;
            }
            levels.push(*value);
        }
    }
    true
}

/// Marks the segments that do not begin at the end of the previous one.
fn mark_jumps(segments: &mut [Segment]) {
    for i in 1..segments.len() {
        let before = segments[i - 1];
        let end = before.after((segments[i].start_ns - before.start_ns) as f64 * 1e-9);
        let scale = end.abs().max(segments[i].q[0].abs()).max(1e-9);
        segments[i].jumps = (segments[i].q[0] - end).abs() > 1e-9 * scale;
    }
}

#[cfg(test)]
mod tests;
