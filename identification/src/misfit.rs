//! The residual of a model against the noise of the recording.
//!
//! The second differences of an angle are those of its noise where the samples are close: for white
//! noise of variance `s^2` they have the variance `6 s^2`. The residuals of a model that describes
//! the recording are as large as that noise. Larger ones are an error of the model, which does not
//! decrease with the number of samples.

use super::experiment::Experiment;
use super::experiment_fit::ExperimentFit;
use super::screening::resolution_deg;

/// Stretches of a recording of which the worst counts: a stop that is met for a moment.
const STRETCHES: usize = 8;
/// Fewest samples of a stretch: the ratio scatters by a tenth.
const LEAST: usize = 40;
/// Root mean square of a rounding error, in counts.
const ROUNDING: f64 = 0.29;
/// Share of the range of the angle that counts as its noise at least: a simulation without noise
/// has none.
const EXACT: f64 = 1e-5;

/// The residual of a model against the noise.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Misfit {
    /// Standard deviation of the noise, deg.
    pub noise_deg: f64,
    /// Root mean square of the residuals, in those of the noise: 1 where the model describes the
    /// recordings.
    pub ratio: f64,
    /// The same of the stretch of a recording where it is largest.
    pub worst: f64,
}

impl Misfit {
    /// Of all experiments.
    pub fn of(experiments: &[Experiment], fits: &[ExperimentFit]) -> Self {
        let (mut squares, mut noise, mut count, mut worst) = (0.0, 0.0, 0.0, 0.0_f64);
        for (run, fit) in experiments.iter().zip(fits) {
            let Some(own) = OfRun::of(&run.recording.angle_deg, fit) else {
                continue;
            };
            squares += own.squares;
            noise += own.count * own.floor.powi(2);
            count += own.count;
            worst = worst.max(own.worst);
        }
        Self {
            noise_deg: (noise / count).sqrt(),
            ratio: (squares / noise).sqrt(),
            worst,
        }
    }
}

struct OfRun {
    squares: f64,
    count: f64,
    floor: f64,
    worst: f64,
}

impl OfRun {
    fn of(angle_deg: &[f64], fit: &ExperimentFit) -> Option<Self> {
        let mut kept: Vec<bool> = fit.residual_deg.iter().map(|r| !r.is_nan()).collect();
        fit.outliers.iter().for_each(|i| kept[*i] = false);
        let take = |column: &[f64]| -> Vec<f64> {
            let pairs = column.iter().zip(&kept);
            pairs
                .filter(|(_, kept)| **kept)
                .map(|(value, _)| *value)
                .collect()
        };
        let (angle, residual) = (take(angle_deg), take(&fit.residual_deg));
        if residual.len() < 3 {
            return None;
        }
        let (low, high) = angle
            .iter()
            .fold((f64::MAX, f64::MIN), |(a, b), y| (y.min(a), y.max(b)));
        let least = (ROUNDING * resolution_deg(angle.iter().copied())).max(EXACT * (high - low));
        // Where samples are far apart, only the residuals show the noise.
        let floor = scatter(&angle).min(scatter(&residual)).max(least);
        let length = residual.len().div_ceil(STRETCHES).max(LEAST);
        let of_stretch = |(angle, residual): (&[f64], &[f64])| {
            // Where an error in time makes the noise larger, the second differences show it.
            let own = scatter(angle).min(scatter(residual)).max(floor);
            (sum_of_squares(residual) / residual.len() as f64).sqrt() / own
        };
        let stretches = angle.chunks(length).zip(residual.chunks(length));
        let stretches = stretches.filter(|(_, residual)| residual.len() >= LEAST.min(length));
        Some(Self {
            squares: sum_of_squares(&residual),
            count: residual.len() as f64,
            floor,
            worst: stretches.map(of_stretch).fold(0.0, f64::max),
        })
    }
}

fn sum_of_squares(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum()
}

/// The standard deviation of white noise with these second differences.
fn scatter(values: &[f64]) -> f64 {
    let squares = values
        .windows(3)
        .map(|w| (w[2] - 2.0 * w[1] + w[0]).powi(2));
    (squares.sum::<f64>() / (6.0 * (values.len().max(3) - 2) as f64)).sqrt()
}
