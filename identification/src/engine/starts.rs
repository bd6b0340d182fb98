//! Starting points: the problem's, those estimated from the data, and random points around both.

use crate::problem::Problem;
use crate::unknowns::{Unknown, Unknowns};
use model_core::sensors::noise::Noise;

/// The problem's starting point, and that estimated from the data where it differs.
pub fn given_and_estimated(problem: &Problem, unknowns: &Unknowns) -> Vec<Vec<f64>> {
    let given = unknowns.start();
    let estimates = problem.estimates();
    let estimated = |(u, given): (&Unknown, &f64)| {
        let value = estimates[u.parameter];
        if u.experiment.is_some() || !value.is_finite() {
            *given
        } else {
            value.clamp(u.low, u.high)
        }
    };
    let from_data: Vec<f64> = unknowns.list.iter().zip(&given).map(estimated).collect();
    if from_data == given {
        vec![given]
    } else {
        vec![given, from_data]
    }
}

/// Point number `index` of a random sequence around a centre.
pub fn scattered(
    unknowns: &Unknowns,
    centre: &[f64],
    spread: f64,
    (seed, index): (u64, usize),
) -> Vec<f64> {
    let mut noise = Noise::new(seed, index as u64);
    let scatter = |(u, centre): (&Unknown, &f64)| {
        // Half of the factors are within 2, nearly all within 8.
        let number = noise.gaussian(spread);
        let moved = if u.is_log_scaled {
            centre * number.exp()
        } else if u.low == 0.0 && u.high.is_finite() {
            // A delay, for example: from zero to several times the estimate.
            centre.max(1e-3 * u.high) * number.exp()
        } else {
            *centre
        };
        moved.clamp(u.low, u.high)
    };
    unknowns.list.iter().zip(centre).map(scatter).collect()
}
