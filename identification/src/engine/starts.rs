//! Where the searches begin: at the problem's start, at that of a first look, and around both.

use crate::problem::Problem;
use crate::unknowns::{Unknown, Unknowns};
use model_core::sensors::noise::Noise;

/// The problem's start, and that of a first look where it is another.
pub fn sure(problem: &Problem, unknowns: &Unknowns) -> Vec<Vec<f64>> {
    let given = unknowns.start();
    let look = problem.model.starting_values(&problem.experiments);
    let from_look = |(u, given): (&Unknown, &f64)| {
        let value = look[u.parameter];
        if u.experiment.is_some() || !value.is_finite() {
            *given
        } else {
            value.clamp(u.low, u.high)
        }
    };
    let looked: Vec<f64> = unknowns.list.iter().zip(&given).map(from_look).collect();
    if looked == given {
        vec![given]
    } else {
        vec![given, looked]
    }
}

/// Point number `index` of those that a seed scatters around a centre.
pub fn scattered(
    unknowns: &Unknowns,
    centre: &[f64],
    spread: f64,
    (seed, index): (u64, usize),
) -> Vec<f64> {
    let mut noise = Noise::new(seed, index as u64);
    let scatter = |(u, centre): (&Unknown, &f64)| {
        // Half of the starts are within a factor of 2 of a size, nearly all within 8.
        let number = noise.gaussian(spread);
        let moved = if u.is_size {
            centre * number.exp()
        } else if u.low == 0.0 && u.high.is_finite() {
            // A delay, say: from nothing to several times the first guess.
            centre.max(1e-3 * u.high) * number.exp()
        } else {
            *centre
        };
        moved.clamp(u.low, u.high)
    };
    unknowns.list.iter().zip(centre).map(scatter).collect()
}
