//! The optimum under a loss that outliers do not decide.
//!
//! Isolated residuals call for it: larger than the scatter of their neighbours, than the motion of
//! the model from the sample before to the sample after, which an error in time explains, and with
//! a considerable share of the cost. Residuals of a model that lacks dynamics are not isolated:
//! their size is information, and squares keep it.

use super::{
    Options, Progress, Solution, assumptions, nested::CancelOnly, outcome, solve as search_all,
};
use crate::experiment::Assumptions;
use crate::experiment_fit::ExperimentFit;
use crate::fit::Fit;
use crate::levenberg::search;
use crate::loss::Loss;
use crate::problem::{IdentifyError, Problem};
use crate::screening::resolution_deg;

/// Multiple of the scatter from which a residual is isolated: no normal variable.
const ISOLATED: f64 = 8.0;
/// The same in counts of the encoder.
const COUNTS: f64 = 3.0;
/// Share of the squared residuals that isolated ones have at least.
const DECISIVE: f64 = 0.1;
/// Quantile of the magnitudes by which the scale is estimated, and that of a normal variable: a
/// fifth may be outliers, and the errors of an incomplete model count in it.
const QUANTILE: f64 = 0.8;
const NORMAL_QUANTILE: f64 = 1.2816;
/// Relative change of the scale at which it has converged.
const CONVERGED: f64 = 0.02;
/// Decrease of the scale from which the optimum may be another one.
const ANOTHER: f64 = 0.7;
/// Most estimates of the scale.
const ROUNDS: usize = 12;

fn fits(problem: &Problem, solution: &Solution) -> Vec<ExperimentFit> {
    let runs = solution.unknowns.runs.iter().enumerate();
    let values = runs.map(|(i, run)| (i, run.values(&solution.found.point)));
    values
        .map(|(i, values)| outcome::experiment_fit(problem, i, &values))
        .collect()
}

/// Whether isolated residuals decide the fit.
pub fn is_called_for(problem: &Problem, solution: &Solution) -> bool {
    let (mut isolated, mut all) = (0.0, 0.0);
    for (run, fit) in problem.experiments.iter().zip(fits(problem, solution)) {
        isolated += isolated_squares(&run.recording.angle_deg, &fit);
        all += fit
            .residual_deg
            .iter()
            .filter(|r| !r.is_nan())
            .map(|r| r * r)
            .sum::<f64>();
    }
    isolated > DECISIVE * all
}

/// The sum of the squares of isolated residuals, deg^2.
fn isolated_squares(angle_deg: &[f64], fit: &ExperimentFit) -> f64 {
    let present: Vec<usize> = (0..fit.residual_deg.len())
        .filter(|&i| !fit.residual_deg[i].is_nan())
        .collect();
    let residual = |k: usize| fit.residual_deg[present[k]];
    let around = |k: usize| {
        let mut near = [k - 2, k - 1, k, k + 1, k + 2].map(residual);
        near.sort_unstable_by(f64::total_cmp);
        near[2]
    };
    let inner = 2..present.len().saturating_sub(2);
    let off: Vec<f64> = inner
        .clone()
        .map(|k| (residual(k) - around(k)).abs())
        .collect();
    // An encoder that mostly repeats its count has a median difference of zero.
    let scatter = scale_deg(off.iter().copied());
    let count = resolution_deg(present.iter().map(|&i| angle_deg[i]));
    let least = (ISOLATED * scatter).max(COUNTS * count);
    let motion = |k: usize| {
        let at = |k: usize| fit.predicted_deg[present[k]];
        (at(k + 1) - at(k - 1)).abs()
    };
    let is_isolated = |(k, off): &(usize, f64)| *off > least.max(motion(*k));
    let isolated = inner.zip(off).filter(is_isolated);
    isolated.map(|(_, off)| off * off).sum()
}

/// The scale of these residuals, deg, which a fifth of outliers does not move far; NaN of nothing.
fn scale_deg(residuals: impl Iterator<Item = f64>) -> f64 {
    let mut sizes: Vec<f64> = residuals.filter(|r| !r.is_nan()).map(f64::abs).collect();
    let place = ((sizes.len() as f64 * QUANTILE) as usize).min(sizes.len().saturating_sub(1));
    if sizes.is_empty() {
        return f64::NAN;
    }
    *sizes.select_nth_unstable_by(place, f64::total_cmp).1 / NORMAL_QUANTILE
}

fn scale_of(fits: &[ExperimentFit]) -> f64 {
    scale_deg(fits.iter().flat_map(|fit| fit.residual_deg.iter().copied()))
}

/// The problem with the loss of Student's distribution at its scale, and its optimum.
pub fn solve(
    problem: &Problem,
    squares: Solution,
    options: &Options,
    progress: &dyn Progress,
    known: &[&Fit],
) -> Result<(Problem, Solution), IdentifyError> {
    let quiet = CancelOnly(progress);
    let is_stopped = || progress.is_stopped();
    let had = squares.assumptions;
    let mut scale = scale_of(&fits(problem, &squares));
    let (mut solution, mut searched_at) = (squares, f64::INFINITY);
    for _ in 0..ROUNDS {
        // Data without noise.
        if !(scale > 0.0 && scale.is_finite()) {
            break;
        }
        let robust = problem.with_loss(Loss::Student { scale_deg: scale });
        let (start, limits) = (&solution.found.point, &options.limits);
        let near = search(&robust, &solution.unknowns, start, limits, &is_stopped);
        // The optimum of squares, to which outliers contributed, may lie far away.
        let is_other = scale < ANOTHER * searched_at;
        if is_other {
            solution = search_all(&robust, options, &quiet, known)?;
            searched_at = scale;
        }
        // Unless all were searched, the cost of the solution is of another scale.
        if let Some(near) = near
            && (!is_other || near.cost < solution.found.cost)
        {
            solution.found = near;
        }
        let next = scale_of(&fits(&robust, &solution));
        let has_converged = (next / scale - 1.0).abs() < CONVERGED;
        if has_converged || is_stopped() {
            break;
        }
        scale = next;
    }
    let robust = problem.with_loss(Loss::Student { scale_deg: scale });
    if had != Assumptions::default() {
        solution.assumptions = had;
        return Ok((robust, solution));
    }
    let (other, decided) = assumptions::decided(&robust, solution, options, progress, known)?;
    Ok((other.unwrap_or(robust), decided))
}
