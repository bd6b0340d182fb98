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
/// The same as a share of the range: friction lets go with a smaller jump.
const LEAST_SHARE: f64 = 0.1;
/// Share of the path in sustained motion from which the samples resolve the motion.
const RESOLVED: f64 = 0.5;
/// The frozen stretches, each without its first reading, which is a measurement.
pub fn find(recording: &Recording, present: &[usize], motion: &Motion) -> Vec<BadSamples> {
    let angles: Vec<f64> = present.iter().map(|&i| recording.angle_deg[i]).collect();
    if motion.sustained < RESOLVED {
        return Vec::new();
    }
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
        if jumps {
            found.push(BadSamples {
                samples,
                fault: Fault::Frozen { jump_deg },
            });
        }
    }
    found
}
