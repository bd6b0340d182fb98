//! Gaps in time in which the command changed: the instant of the change is unknown, and with it the
//! response after the gap until it has settled.

use super::motion::Motion;
use super::{BadSamples, Fault};
use crate::experiment::Experiment;
use crate::recording::Recording;
use crate::start::DataSummary;

/// Multiple of the usual sample interval from which an interval is a gap.
pub const GAP_STEPS: f64 = 5.0;
/// Change of the command across a gap, as a share of its range, from which it matters.
const CHANGED: f64 = 0.01;
/// Expected changes in a gap, by their frequency, from which the command is taken to have changed.
const LIKELY: f64 = 0.3;
/// Lags after which a response has settled: five time constants leave 0.7 %.
const SETTLED_LAGS: f64 = 5.0;
/// Share of the recording that may be left out after gaps; a recording of gaps is used as it is.
const MOST: f64 = 0.5;

/// The responses after gaps, to where they have settled.
pub fn find(recording: &Recording, motion: &Motion) -> Vec<BadSamples> {
    let (time, command) = (&recording.time_s, &recording.command_deg);
    let numbers = || command.iter().filter(|c| c.is_finite());
    let range = numbers().fold(f64::NEG_INFINITY, |m, c| m.max(*c))
        - numbers().fold(f64::INFINITY, |m, c| m.min(*c));
    let is_change = |i: &usize| (command[*i] - command[i - 1]).abs() > CHANGED * range;
    let is_gap = |i: &usize| time[*i] - time[i - 1] > GAP_STEPS * motion.step_s;
    let mut gaps: Vec<usize> = (1..recording.len()).filter(is_gap).collect();
    if gaps.is_empty() {
        return Vec::new();
    }
    let changes = (1..recording.len()).filter(is_change).count();
    let per_s = changes as f64 / (time[time.len() - 1] - time[0]);
    // A command that changes often has changed there, too, and perhaps back again.
    let is_likely = |i: &usize| per_s * (time[*i] - time[i - 1]) > LIKELY;
    gaps.retain(|i| is_change(i) || is_likely(i));
    if gaps.is_empty() {
        return Vec::new();
    }
    // The recording is checked again, with a message, before it is fitted.
    let Ok(run) = Experiment::try_new(recording.clone()) else {
        return Vec::new();
    };
    let data = DataSummary::of(&[run]);
    let slower = data.rate_up_deg_s.min(data.rate_down_deg_s);
    let settled_s = |i: usize| {
        let change = if is_likely(&i) {
            range
        } else {
            (command[i] - command[i - 1]).abs()
        };
        let change_deg = data.gain.abs() * change;
        SETTLED_LAGS * data.lag_s + change_deg / slower.max(1.0)
    };
    let after = |&i: &usize| {
        let until = time[i] + settled_s(i);
        let end = time.partition_point(|t| *t <= until);
        BadSamples {
            samples: i..end,
            fault: Fault::AfterGap {
                gap_s: time[i] - time[i - 1],
            },
        }
    };
    let found: Vec<BadSamples> = gaps.iter().map(after).collect();
    let left_out: usize = found.iter().map(|b| b.samples.len()).sum();
    if left_out as f64 > MOST * recording.len() as f64 {
        return Vec::new();
    }
    found
}
