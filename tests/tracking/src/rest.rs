//! Shafts at rest: what moves there, how far they are from the target, and what it takes to hold
//! them.

use model_core::time::CONTROL_PERIOD_S as PERIOD_S;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::bench::Bench;
use super::{PERIODS, SEEDS, Sample, Setup, error_deg, follow, mean};

/// Shafts that rest under a torque.
pub struct Rest {
    /// Changes of the duty's sign in a second.
    pub changes_hz: f64,
    /// Greatest motion, deg.
    pub motion_deg: f64,
    /// Rms difference from the target, deg.
    pub error_deg: f64,
    /// Greatest difference from the target, deg.
    pub greatest_error_deg: f64,
}

impl Rest {
    /// Of a shaft whose motion has ended.
    fn of(samples: &[Sample]) -> Self {
        let changes = samples.windows(2);
        let changes = changes.filter(|pair| pair[0].duty_pct * pair[1].duty_pct < 0.0);
        let angles = samples.iter().map(|sample| sample.angle_deg);
        let (low, high) = angles.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), angle| {
            (low.min(angle), high.max(angle))
        });
        let errors = samples
            .iter()
            .map(|it| (it.command_deg - it.angle_deg).abs());
        Self {
            changes_hz: changes.count() as f64 / (samples.len() as f64 * PERIOD_S),
            motion_deg: high - low,
            error_deg: error_deg(samples),
            greatest_error_deg: errors.fold(0.0, f64::max),
        }
    }
}

/// Of all seeds: means of changes and rms, and the greatest of the others.
pub fn rest(setup: &Setup, bench: Bench, torque_nm: f64) -> Rest {
    let of_seed = |seed: u64| {
        let mut drive = bench.drive(setup, seed, 4);
        drive.defects().torque_nm = torque_nm;
        let samples = follow(&mut drive, 4, |_| 12.3 + 0.1 * seed as f64);
        Rest::of(&samples[PERIODS as usize / 2..])
    };
    let each: Vec<Rest> = (0..SEEDS).into_par_iter().map(of_seed).collect();
    let mean = |part: fn(&Rest) -> f64| each.iter().map(part).sum::<f64>() / each.len() as f64;
    let greatest = |part: fn(&Rest) -> f64| each.iter().map(part).fold(0.0, f64::max);
    Rest {
        changes_hz: mean(|it| it.changes_hz),
        motion_deg: greatest(|it| it.motion_deg),
        error_deg: mean(|it| it.error_deg),
        greatest_error_deg: greatest(|it| it.greatest_error_deg),
    }
}

/// Greatest way of a shaft that rests when a torque begins, deg, and rms of the duty about its mean
/// under the torque, %.
pub fn loaded(setup: &Setup, torque_nm: f64) -> (f64, f64) {
    let motions = (0..SEEDS).into_par_iter().map(|seed| {
        let mut drive = setup.drive(seed, 4);
        let target = |_| 12.3 + 0.1 * seed as f64;
        let rested = follow(&mut drive, 4, target);
        drive.defects().torque_nm = torque_nm;
        let from_deg = rested[rested.len() - 1].angle_deg;
        let samples = follow(&mut drive, 4, target);
        let ways = (samples.iter()).map(|sample| (sample.angle_deg - from_deg).abs());
        let held = &samples[samples.len() / 2..];
        let number = held.len() as f64;
        let mean_pct = held.iter().map(|sample| sample.duty_pct).sum::<f64>() / number;
        let square = |sample: &Sample| (sample.duty_pct - mean_pct).powi(2);
        let rms_pct = (held.iter().map(square).sum::<f64>() / number).sqrt();
        (ways.fold(0.0, f64::max), rms_pct / SEEDS as f64)
    });
    motions.reduce(|| (0.0, 0.0), |a, b| (a.0.max(b.0), a.1 + b.1))
}

/// Copper loss while a torque is held, W.
pub fn holding_loss_w(setup: &Setup, torque_nm: f64) -> f64 {
    mean(|seed| {
        let mut drive = setup.drive(seed, 4);
        drive.defects().torque_nm = torque_nm;
        follow(&mut drive, 4, |_| 12.3 + 0.1 * seed as f64);
        drive.copper_loss_j() / (f64::from(PERIODS) * PERIOD_S)
    })
}
