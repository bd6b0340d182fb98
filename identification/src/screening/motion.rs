//! Noise and fastest motion of a recorded angle, by statistics that single readings do not move.

use crate::recording::Recording;
use crate::statistics::slots::median_step_of_s;

/// Standard deviation of a normal variable by its median magnitude.
const SIGMA_BY_MEDIAN: f64 = 1.4826;

/// Share of the sustained motions that are at most as fast as [`Motion::rate_deg_s`].
const USUAL: f64 = 0.95;

/// The coarsest encoder has this many levels in the range of the recording: the few differences of
/// a noiseless recording may all be motion.
const FEWEST_LEVELS: f64 = 200.0;

/// Two successive differences of one sign above this multiple of their noise are motion: those of
/// noise have opposite signs.
const ABOVE_NOISE: f64 = 2.0;

/// Scales of the differences from sample to sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Standard deviation of the noise of an angle, deg.
    pub noise_deg: f64,
    /// The smallest difference of two angles, deg: the resolution of a noiseless encoder.
    pub resolution_deg: f64,
    /// The range of the angle, deg.
    pub range_deg: f64,
    /// A rate that two differences in succession reach, and nearly no others exceed, deg/s.
    pub rate_deg_s: f64,
    /// The greatest such rate, deg/s.
    pub greatest_rate_deg_s: f64,
    /// Share of the path that the angle travels in such a succession: near one where the samples
    /// resolve the motion, near zero where a step takes place from one sample to the next.
    pub sustained: f64,
    /// The usual sample interval, s.
    pub step_s: f64,
}

impl Motion {
    /// The motion in these samples.
    pub fn of(recording: &Recording, present: &[usize]) -> Self {
        let angle = |k: usize| recording.angle_deg[present[k]];
        let time = |k: usize| recording.time_s[present[k]];
        let step_s = median_step_of_s(&recording.time_s, &recording.angle_deg);
        let step_s = step_s.unwrap_or(0.0);
        let count = present.len();
        let second = (1..count.saturating_sub(1))
            .map(|k| (angle(k - 1) - 2.0 * angle(k) + angle(k + 1)).abs());
        // The second difference of white noise has six times its variance.
        let noise_deg = SIGMA_BY_MEDIAN * median(second.collect()) / 6.0_f64.sqrt();
        let differences: Vec<f64> = (1..count).map(|k| angle(k) - angle(k - 1)).collect();
        let range_deg = range((0..count).map(angle));
        let resolution_deg = resolution_deg((0..count).map(angle));
        let least = ABOVE_NOISE * 2.0_f64.sqrt() * noise_deg + 0.5 * resolution_deg;
        let rate = |k: usize| {
            let dt = (time(k + 1) - time(k)).max(0.5 * step_s);
            differences[k].abs() / dt
        };
        let (mut rates, mut path, mut sustained) = (Vec::new(), 0.0, 0.0);
        for (k, pair) in differences.windows(2).enumerate() {
            let both = pair[0].abs().min(pair[1].abs());
            if pair[0].abs() > least {
                path += pair[0].abs();
            }
            if pair[0] * pair[1] > 0.0 && both > least {
                rates.push(rate(k).min(rate(k + 1)));
                sustained += both;
            }
        }
        rates.sort_by(f64::total_cmp);
        let usual = ((rates.len() as f64 * USUAL) as usize).min(rates.len().saturating_sub(1));
        Self {
            noise_deg,
            resolution_deg,
            range_deg,
            rate_deg_s: rates.get(usual).copied().unwrap_or(0.0),
            greatest_rate_deg_s: rates.last().copied().unwrap_or(0.0),
            sustained: if path > 0.0 { sustained / path } else { 0.0 },
            step_s,
        }
    }
}

/// The smallest difference of two successive angles, deg, but not more than that of the coarsest
/// encoder.
pub fn resolution_deg(angles: impl Iterator<Item = f64> + Clone) -> f64 {
    let pairs = angles.clone().zip(angles.clone().skip(1));
    let sizes = pairs.map(|(a, b)| (b - a).abs()).filter(|d| *d > 0.0);
    sizes.fold(range(angles) / FEWEST_LEVELS, f64::min)
}

/// The range of the angle; zero of nothing.
fn range(angles: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = angles.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| {
        (low.min(y), high.max(y))
    });
    (high - low).max(0.0)
}

/// The median; zero of nothing.
pub fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
