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
    outcome::fits(problem, &solution.unknowns, &solution.found.point)
}

/// Whether isolated residuals decide the fit.
pub fn is_called_for(problem: &Problem, solution: &Solution) -> bool {
    let fits = fits(problem, solution);
    let isolated = isolated(problem, &fits);
    let isolated: f64 = isolated.iter().flatten().map(|(_, off)| off * off).sum();
    let residuals = fits.iter().flat_map(|fit| &fit.residual_deg);
    isolated
        > DECISIVE
            * residuals
                .filter(|r| !r.is_nan())
                .map(|r| r * r)
                .sum::<f64>()
}

/// Whether the optimum of squares describes the samples that are not isolated at least as well as
/// the robust one: then the residuals that count less in this one are not outliers but what the
/// model lacks.
pub fn is_worse(problem: &Problem, squares: &Solution, robust: (&Problem, &Solution)) -> bool {
    let fits = [fits(problem, squares), fits(robust.0, robust.1)];
    let isolated: Vec<Isolated> = fits.iter().map(|fits| isolated(problem, fits)).collect();
    let sum = |fits: &[ExperimentFit]| {
        let runs = fits.iter().enumerate().map(|(run, fit)| {
            let is_isolated = |i: usize| {
                let mut all = isolated.iter().flat_map(|of_fit| &of_fit[run]);
                all.any(|(place, _)| *place == i)
            };
            let rest = fit.residual_deg.iter().enumerate();
            let rest = rest.filter(|(i, r)| !r.is_nan() && !is_isolated(*i));
            rest.map(|(_, r)| r * r).sum::<f64>()
        });
        runs.sum::<f64>()
    };
    sum(&fits[0]) <= sum(&fits[1])
}

/// The isolated residuals of each run: their samples, and by how much they are off.
type Isolated = Vec<Vec<(usize, f64)>>;

fn isolated(problem: &Problem, fits: &[ExperimentFit]) -> Isolated {
    let runs = problem.experiments.iter().zip(fits);
    runs.map(|(run, fit)| isolated_of_run(&run.recording.angle_deg, fit))
        .collect()
}

fn isolated_of_run(angle_deg: &[f64], fit: &ExperimentFit) -> Vec<(usize, f64)> {
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
    // An error in time, in intervals of two samples: off by as much as they move, or by more where
    // most instants are uncertain.
    let moving = inner.clone().zip(&off);
    let moving = moving.filter(|(k, _)| motion(*k) > least);
    let late = scale_deg(moving.map(|(k, off)| off / motion(k)));
    let late = (ISOLATED * if late.is_nan() { 0.0 } else { late }).max(1.0);
    let is_isolated = |(k, off): &(usize, f64)| *off > least.max(late * motion(*k));
    let isolated = inner.zip(off).filter(is_isolated);
    isolated.map(|(k, off)| (present[k], off)).collect()
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
