//! Likelihood-ratio tests of parameters that the data do not require.
//!
//! A rate limit just below the fastest motion of a recording always fits a little better, because
//! it cuts off noise. A limit without which the other parameters fit as well, by the likelihood
//! ratio, is moved beyond all observed rates; it has no standard error then.
//!
//! An effect that another one may take the place of, such as viscous friction that of the back-EMF,
//! is set to zero where the recordings do not show it: a held-out recording may require the other
//! one.
//!
//! A model with a nested model always fits a little better as well, at arbitrary values of its
//! additional parameters, and may predict held-out recordings much worse. Where the additional
//! parameters are not significant, the model is reported at the optimum of the nested one.

use super::nested::NestedStart;
use super::{Solution, outcome};
use crate::levenberg::{Found, Limits, search};
use crate::model::ActiveLimit;
use crate::normal::{cost, normal};
use crate::problem::Problem;
use crate::statistics::{Correlations, distributions::chi_squared_exceeds};
use crate::unknowns::{Unknown, Unknowns};

/// Threshold of twice the logarithm of the likelihood ratio: one insignificant parameter exceeds it
/// in one case of six hundred (chi-squared, one degree of freedom).
const ACCIDENT: f64 = 10.0;

/// The same of an effect that recordings show: two standard errors.
const SHOWN: f64 = 4.0;

/// Value above which a limit is certainly significant, so that no search without it is needed.
const HOPELESS: f64 = 1e4;

/// The optimum with every insignificant limit removed.
pub fn without_insignificant_limits(
    problem: &Problem,
    unknowns: &Unknowns,
    mut found: Found,
    limits: &Limits,
    is_stopped: &(dyn Fn() -> bool + Sync),
) -> Found {
    let freedom = freedom(problem, unknowns);
    let accident = ACCIDENT * unevenness(problem, unknowns, &found);
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
        if worse(refit.cost) < accident {
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

/// The optimum with every negligible effect at zero that the recordings do not show, and the
/// unknowns of these effects.
pub fn without_negligible_effects(
    problem: &Problem,
    solution: &Solution,
    limits: &Limits,
    is_stopped: &(dyn Fn() -> bool + Sync),
) -> (Found, Vec<usize>) {
    let (mut found, mut neglected) = (solution.found.clone(), Vec::new());
    let mut unknowns = solution.unknowns.clone();
    let parameter = |unknown: &Unknown| &problem.model.parameters()[unknown.parameter];
    let nested = problem.model.nested_models().into_iter();
    let nested = nested.filter(|nested| solution.no_better_than == Some(nested.name()));
    for nested in nested {
        // The estimates remain those of the nested model.
        let list = unknowns.list.iter_mut().zip(&found.point);
        let fixed = list.filter(|(u, _)| nested.is_fixed_by_default(parameter(u).name));
        fixed.for_each(|(unknown, at)| (unknown.low, unknown.high) = (*at, *at));
    }
    for column in 0..unknowns.list.len() {
        let unknown = unknowns.list[column];
        let is_candidate = parameter(&unknown).is_negligible && unknown.low == 0.0;
        if !is_candidate || found.point[column] == 0.0 || is_stopped() {
            continue;
        }
        let mut without = unknowns.clone();
        without.list[column].high = 0.0;
        let mut start = found.point.clone();
        start[column] = 0.0;
        let refit = search(problem, &without, &start, limits, is_stopped);
        let samples = independent(problem, &unknowns, &found.point);
        let is_hidden = |refit: &Found| (refit.cost / found.cost - 1.0) * samples < SHOWN;
        if let Some(refit) = refit.filter(is_hidden) {
            neglected.push(column);
            (unknowns, found) = (without, refit);
        }
    }
    (found, neglected)
}

/// The number of independent residuals; that of all of them where no correlation is known.
fn independent(problem: &Problem, unknowns: &Unknowns, point: &[f64]) -> f64 {
    let fits = outcome::fits(problem, unknowns, point);
    let runs = problem.experiments.iter().zip(&fits);
    let correlations = runs.filter_map(|(run, fit)| {
        let recording = &run.recording;
        Correlations::of(&recording.time_s, &fit.residual_deg, &recording.command_deg)
    });
    let sum: f64 = correlations.map(|c| c.effective_samples).sum();
    if sum > 0.0 {
        sum
    } else {
        freedom(problem, unknowns)
    }
}

/// The mean square of the residuals at a limit of the rate, by that of all of them, at least 1: an
/// error in time makes them largest where the rate is, and a limit cuts them off.
fn unevenness(problem: &Problem, unknowns: &Unknowns, found: &Found) -> f64 {
    let (mut limited, mut all) = ((0.0, 0.0_f64), (0.0, 0.0_f64));
    for fit in outcome::fits(problem, unknowns, &found.point) {
        let samples = fit.residual_deg.iter().zip(&fit.state);
        for (residual, state) in samples.filter(|(residual, _)| !residual.is_nan()) {
            let square = residual * residual;
            all = (all.0 + square, all.1 + 1.0);
            if matches!(state, ActiveLimit::RateUp | ActiveLimit::RateDown) {
                limited = (limited.0 + square, limited.1 + 1.0);
            }
        }
    }
    let ratio = limited.0 / limited.1 / (all.0 / all.1);
    if ratio > 1.0 { ratio } else { 1.0 }
}

/// Whether a cost of `less` is significantly better than a cost of `more`.
pub fn is_significant(problem: &Problem, unknowns: &Unknowns, more: f64, less: f64) -> bool {
    (more - less) * freedom(problem, unknowns) / less > ACCIDENT
}

/// Degrees of freedom: samples less unknowns.
fn freedom(problem: &Problem, unknowns: &Unknowns) -> f64 {
    let angles = problem.experiments.iter().map(|e| &e.recording.angle_deg);
    let samples = angles.flatten().filter(|a| !a.is_nan()).count();
    samples.saturating_sub(unknowns.list.len()).max(1) as f64
}

/// The optimum, or that of the best nested model with its name, if the fit is not significantly
/// better.
pub fn reduced_to_nested(
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
    // Coloured residuals are fewer than samples, and another few parameters fit them by chance.
    let samples = independent(problem, unknowns, &found.point);
    let worse = (simple / found.cost - 1.0) * samples;
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
