//! What the data do not need.
//!
//! A limit of the rate just below the fastest motion of a recording always fits a little better: it
//! cuts off noise. Such a limit is an accident. One without which the rest fits as well, by the
//! likelihood ratio, is moved beyond all that was seen; its standard error is none then.
//!
//! A model that contains a simpler one always fits a little better too, and what it has beyond that one then
//! stands anywhere: a recording that is left out is predicted worse by it, at times by far. Where the rest
//! is worth no more than chance the model stays where the simpler one fits best.

use super::nested::NestedStart;
use crate::levenberg::{Found, Limits, search};
use crate::normal::{cost, normal};
use crate::problem::Problem;
use crate::statistics::distributions::chi_squared_exceeds;
use crate::unknowns::Unknowns;

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
    let freedom = freedom(problem, unknowns);
    for (column, unknown) in unknowns.list.iter().enumerate() {
        if !problem.model.parameters()[unknown.parameter].is_limit || is_stopped() {
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

/// Whether what costs `less` is likelier than what costs `more` by more than an accident.
pub fn is_worth_a_choice(problem: &Problem, unknowns: &Unknowns, more: f64, less: f64) -> bool {
    (more - less) * freedom(problem, unknowns) / less > ACCIDENT
}

/// Samples beyond the unknowns.
fn freedom(problem: &Problem, unknowns: &Unknowns) -> f64 {
    let angles = problem.experiments.iter().map(|e| &e.recording.angle_deg);
    let samples = angles.flatten().filter(|a| !a.is_nan()).count();
    samples.saturating_sub(unknowns.list.len()).max(1) as f64
}

/// The optimum, or that of the special case that fits best and no worse but for chance, with its name.
pub fn needless_rest(
    problem: &Problem,
    unknowns: &Unknowns,
    found: Found,
    nested: &[NestedStart],
) -> (Found, Option<&'static str>) {
    if !problem.model.contains_nested_models_exactly() {
        return (found, None);
    }
    let cases = nested.iter().filter_map(|nested| {
        let (name, beyond) = nested.model?;
        Some((cost(problem, unknowns, &nested.point), name, beyond, nested))
    });
    let Some((simple, name, beyond, nested)) = cases.min_by(|a, b| a.0.total_cmp(&b.0)) else {
        return (found, None);
    };
    let worse = (simple - found.cost) * freedom(problem, unknowns) / found.cost;
    let is_by_chance =
        chi_squared_exceeds(worse, beyond as f64) > chi_squared_exceeds(ACCIDENT, 1.0);
    if !is_by_chance {
        return (found, None);
    }
    let there = normal(problem, unknowns, &nested.point);
    let simple = Found {
        point: nested.point.clone(),
        cost: there.cost,
        information: there.hessian,
        ..found
    };
    (simple, Some(name))
}
