//! Limits that the data do not need.
//!
//! A limit of the rate just below the fastest motion of a recording always fits a little better: it
//! cuts off noise. Such a limit is an accident. One without which the rest fits as well, by the
//! likelihood ratio, is moved beyond all that was seen; its standard error is none then.

use crate::identify::levenberg::{Found, Limits, search};
use crate::identify::normal::{cost, normal};
use crate::identify::problem::Problem;
use crate::identify::unknowns::Unknowns;

/// Twice the logarithm of the likelihood ratio that one parameter reaches by accident in one case
/// of six hundred (chi-squared, one degree of freedom).
const ACCIDENT: f64 = 10.0;

/// Of that size, no other values of the remaining parameters make up for a missing limit.
const HOPELESS: f64 = 1e4;

/// The optimum with every needless limit out of the way.
pub fn needless_limits(
    problem: &Problem,
    unknowns: &Unknowns,
    mut found: Found,
    limits: &Limits,
    is_stopped: &(dyn Fn() -> bool + Sync),
) -> Found {
    let angles = problem.experiments.iter().map(|e| &e.recording.angle_deg);
    let samples = angles.flatten().filter(|a| !a.is_nan()).count();
    let freedom = samples.saturating_sub(unknowns.list.len()).max(1) as f64;
    for (column, unknown) in unknowns.list.iter().enumerate() {
        if !problem.model.is_limit(unknown.parameter) || is_stopped() {
            continue;
        }
        let worse = |other: f64| (other - found.cost) * freedom / found.cost;
        let mut without = found.point.clone();
        without[column] = unknown.high;
        let other = cost(problem, unknowns, &without);
        if worse(other).is_nan() || worse(other) >= HOPELESS {
            continue;
        }
        let Some(mut refit) = search(problem, unknowns, &without, limits, is_stopped) else {
            continue;
        };
        if worse(refit.cost) < ACCIDENT {
            let beyond = (2.0 * found.point[column]).min(unknown.high);
            refit.point[column] = beyond;
            let there = normal(problem, unknowns, &refit.point);
            (refit.cost, refit.information) = (there.cost, there.hessian);
            refit.iterations += found.iterations;
            found = refit;
        }
    }
    found
}
