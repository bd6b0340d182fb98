//! Readings that repeat exactly while the shaft moves, as of a sensor that hangs or a link that
//! repeats its last message.

use super::motion::Motion;
use super::{BadSamples, Fault};
use crate::recording::Recording;

/// The fewest equal readings.
const FEWEST: usize = 8;
/// The next reading is farther away than this multiple of the fastest motion.
const TIMES_MOTION: f64 = 3.0;
/// The same as a multiple of the noise.
const TIMES_NOISE: f64 = 8.0;
/// The same as a share of the range: friction releases with a smaller jump.
const LEAST_SHARE: f64 = 0.1;
/// The fewest equal readings where noise makes a repetition rare.
const FEWEST_IN_NOISE: usize = 16;
/// Share of equal neighbours below which it is rare: sixteen in a row are then below 3e-4.
const RARE: f64 = 0.6;
/// The next reading is then farther away than this multiple of the usual motion.
const RARE_TIMES_MOTION: f64 = 1.5;
/// They are so many times as long as any other repetition: friction that holds the shaft at each
/// reversal is no fault.
const TIMES_OTHERS: usize = 4;
/// Change of the command meanwhile, as a share of its range, from which the shaft should move.
const COMMANDED: f64 = 0.05;
/// The time before in which a change counts as well, s.
const BEFORE_S: f64 = 0.1;
/// Share of the path in sustained motion from which the samples resolve the motion.
const RESOLVED: f64 = 0.5;
/// The frozen stretches, each without its first reading, which is a measurement.
pub fn find(recording: &Recording, present: &[usize], motion: &Motion) -> Vec<BadSamples> {
    let angles: Vec<f64> = present.iter().map(|&i| recording.angle_deg[i]).collect();
    if motion.sustained < RESOLVED {
        return Vec::new();
    }
    let equal = angles.windows(2).filter(|w| w[0] == w[1]).count();
    let mut lengths: Vec<usize> = angles.chunk_by(|a, b| a == b).map(<[f64]>::len).collect();
    lengths.sort_unstable_by(|a, b| b.cmp(a));
    let others = lengths.get(1).copied().unwrap_or(0);
    let is_rare = |length: usize| {
        let (equal, count) = (equal + 1 - length, angles.len() - length);
        length >= FEWEST_IN_NOISE.max(TIMES_OTHERS * others) && (equal as f64) < RARE * count as f64
    };
    let mut found = Vec::new();
    let mut first = 0;
    for run in angles.chunk_by(|a, b| a == b) {
        let (start, end) = (first, first + run.len());
        first = end;
        if run.len() < FEWEST || end >= angles.len() {
            continue;
        }
        let samples = present[start + 1]..present[end - 1] + 1;
        let jump_deg = (angles[end] - run[0]).abs();
        let wide_s = recording.time_s[present[end]] - recording.time_s[present[end - 1]];
        let reach = motion.greatest_rate_deg_s * wide_s.max(motion.step_s);
        let noise = TIMES_NOISE * motion.noise_deg + 2.0 * motion.resolution_deg;
        let jumps = jump_deg > (TIMES_MOTION * reach + noise).max(LEAST_SHARE * motion.range_deg);
        let usual = RARE_TIMES_MOTION * motion.rate_deg_s * wide_s.max(motion.step_s);
        let jumps_in_noise = jump_deg > usual + 0.5 * noise;
        if jumps || jumps_in_noise && is_rare(run.len()) && is_commanded(recording, &samples) {
            found.push(BadSamples {
                samples,
                fault: Fault::Frozen { jump_deg },
            });
        }
    }
    found
}

/// Whether the command changes during these samples, or shortly before.
fn is_commanded(recording: &Recording, samples: &std::ops::Range<usize>) -> bool {
    let (time, command) = (&recording.time_s, &recording.command_deg);
    let from = time.partition_point(|t| *t < time[samples.start] - BEFORE_S);
    let range = |values: &[f64]| {
        let numbers = || values.iter().filter(|v| v.is_finite());
        let low = numbers().fold(f64::INFINITY, |m, v| m.min(*v));
        numbers().fold(f64::NEG_INFINITY, |m, v| m.max(*v)) - low
    };
    range(&command[from..samples.end]) > COMMANDED * range(command)
}
