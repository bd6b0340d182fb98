//! Isolated readings: away from both neighbours and back.

use super::motion::{Motion, median};
use super::{BadSamples, Fault};
use crate::recording::Recording;

/// The most samples of a spike.
const LONGEST: usize = 3;
/// Least distance from both neighbours, as a multiple of what the fastest motion covers meanwhile.
const TIMES_MOTION: f64 = 3.0;
/// The same as a multiple of the noise.
const TIMES_NOISE: f64 = 8.0;
/// The same, deg: smaller ones hardly move an estimate.
const LEAST_DEG: f64 = 0.5;
/// Least distance as a multiple of the change between the two neighbours.
const TIMES_CHANGE: f64 = 2.0;
/// Least distance as a multiple of the median second difference nearby: an oscillation of a few
/// samples per period is no sequence of spikes.
const TIMES_ROUGHNESS: f64 = 4.0;
/// Samples on each side for that median.
const NEARBY: usize = 6;
/// Share of the samples above which the readings are the rule, and none is left out.
const MOST: f64 = 0.1;
/// Time in which the angle may answer a pulse of the command, s.
const ANSWER_S: f64 = 0.5;
/// A pulse of the command that explains a spike has at least this share of its size.
const EXPLAINS: f64 = 0.25;
/// Searches for further spikes once the first are left out.
const PASSES: usize = 4;

/// The spikes in the samples `present`, from which they are removed, and the motion of the others.
pub fn find(recording: &Recording, present: &mut Vec<usize>) -> (Vec<BadSamples>, Motion) {
    let mut motion = Motion::of(recording, present);
    let (all, of_all) = (present.clone(), motion);
    let mut found = Vec::new();
    let mut count = 0;
    for _ in 0..PASSES {
        let mut candidates = candidates(recording, present, &motion);
        if candidates.is_empty() {
            break;
        }
        candidates.sort_by(|a, b| {
            b.off_deg
                .total_cmp(&a.off_deg)
                .then(a.length.cmp(&b.length))
        });
        let mut is_taken = vec![false; present.len()];
        for Candidate {
            first,
            length,
            off_deg,
        } in candidates
        {
            // A neighbour of a spike was compared with the spike.
            let around = first - 1..(first + length + 1).min(present.len());
            if is_taken[around].iter().any(|taken| *taken) {
                continue;
            }
            is_taken[first..first + length].fill(true);
            count += length;
            found.push(BadSamples {
                samples: present[first]..present[first + length - 1] + 1,
                fault: Fault::Spike { off_deg },
            });
        }
        let mut taken = is_taken.iter();
        present.retain(|_| taken.next() == Some(&false));
        motion = Motion::of(recording, present);
    }
    if count as f64 > MOST * all.len() as f64 {
        *present = all;
        return (Vec::new(), of_all);
    }
    (found, motion)
}

/// A possible spike: places in the list of present samples.
struct Candidate {
    first: usize,
    length: usize,
    off_deg: f64,
}

fn candidates(recording: &Recording, present: &[usize], motion: &Motion) -> Vec<Candidate> {
    let angle = |k: usize| recording.angle_deg[present[k]];
    let time = |k: usize| recording.time_s[present[k]];
    let noise = TIMES_NOISE * motion.noise_deg + 2.0 * motion.resolution_deg;
    let mut candidates = Vec::new();
    for first in 1..present.len().saturating_sub(1) {
        let before = angle(first - 1);
        // Most samples end here.
        if (angle(first) - before).abs() < LEAST_DEG {
            continue;
        }
        for length in 1..=LONGEST.min(present.len() - 1 - first) {
            let after = angle(first + length);
            let (high, low) = (before.max(after), before.min(after));
            let group = || (first..first + length).map(angle);
            let above = group().fold(f64::INFINITY, |m, y| m.min(y - high));
            let below = group().fold(f64::INFINITY, |m, y| m.min(low - y));
            let off_deg = above.max(below);
            let last = first + length - 1;
            let wide_s = (time(first) - time(first - 1)).max(time(last + 1) - time(last));
            let reach = TIMES_MOTION * motion.rate_deg_s * wide_s.max(motion.step_s);
            let least = LEAST_DEG
                .max(reach + noise)
                .max(TIMES_CHANGE * (high - low));
            if off_deg > least
                && off_deg > TIMES_ROUGHNESS * roughness(&angle, first, length, present.len())
                && !is_commanded(recording, present[first], length, off_deg)
            {
                candidates.push(Candidate {
                    first,
                    length,
                    off_deg,
                });
            }
        }
    }
    candidates
}

/// The median second difference beside a group of samples.
fn roughness(angle: &impl Fn(usize) -> f64, first: usize, length: usize, count: usize) -> f64 {
    let before = first.saturating_sub(NEARBY)..first;
    let after = first + length..(first + length + NEARBY).min(count);
    let second = [before, after].into_iter().flat_map(|side| {
        let inner = side.start + 1..side.end.saturating_sub(1);
        inner.map(|k| (angle(k - 1) - 2.0 * angle(k) + angle(k + 1)).abs())
    });
    median(second.collect())
}

/// Whether the command made a pulse of about this length shortly before.
fn is_commanded(recording: &Recording, sample: usize, length: usize, off_deg: f64) -> bool {
    let (time, command) = (&recording.time_s, &recording.command_deg);
    let width = 4 * (length + 1);
    let is_pulse = |centre: usize| {
        let differences = |range: std::ops::Range<usize>, sign: f64| {
            let sizes = range.map(move |i| sign * (command[centre] - command[i]));
            sizes.filter(|d| !d.is_nan()).fold(0.0, f64::max)
        };
        let before = centre.saturating_sub(width)..centre;
        let after = centre + 1..(centre + 1 + width).min(command.len());
        [1.0, -1.0].into_iter().any(|sign| {
            let both = differences(before.clone(), sign).min(differences(after.clone(), sign));
            both >= EXPLAINS * off_deg
        })
    };
    let from = time[..sample].partition_point(|t| *t < time[sample] - ANSWER_S);
    (from..sample).any(is_pulse)
}
