//! Makes a [`Fit`] of a finished search.

use nalgebra::DMatrix;

use super::{Solution, combinations, drift, intervals};
use crate::consistency::Consistency;
use crate::covariance::{Covariance, covariance};
use crate::experiment_fit::ExperimentFit;
use crate::fit::{Bound, Estimate, Fit};
use crate::levenberg::Found;
use crate::limited::Limited;
use crate::loss::Loss;
use crate::misfit::Misfit;
use crate::model::ActiveLimit;
use crate::problem::{Problem, Scope, Spec};
use crate::unknowns::{Unknown, Unknowns};

/// Relative standard error above which a parameter is not identifiable.
const VAGUE: f64 = 0.5;

/// Weight below which a sample is listed as an outlier.
const OUTLIER_WEIGHT: f64 = 0.1;

/// The fit at the end of a search; the unknowns of `neglected` are zero because the recordings do
/// not show them.
pub fn fit(problem: &Problem, solution: &Solution, neglected: &[usize]) -> Fit {
    let Solution {
        unknowns, found, ..
    } = solution;
    let bounds: Vec<Option<Bound>> = (0..found.point.len())
        .map(|i| bound(unknowns, i, found.point[i]))
        .collect();
    let at_bound: Vec<bool> = bounds.iter().map(Option::is_some).collect();
    // A limit of the search does not determine a parameter, and the others not beside it.
    let is_zero = |(bound, at): (&Option<Bound>, &f64)| *bound == Some(Bound::Low) && *at == 0.0;
    let mut is_held: Vec<bool> = bounds.iter().zip(&found.point).map(is_zero).collect();
    // The errors of the others include that it may not be zero.
    neglected.iter().for_each(|column| is_held[*column] = false);
    let experiments = fits(problem, unknowns, &found.point);
    let misfit = Misfit::of(&problem.experiments, &experiments);
    let (mut covariance, blocks) = covariance(problem, unknowns, found, &is_held, &experiments);
    let mut consistency = Consistency::of(problem, unknowns, &found.point, &blocks, &covariance);
    consistency.drift = drift::of(problem, unknowns, found, &experiments);
    intervals::widen(problem, solution, &consistency, &mut covariance);
    let ends = intervals::profiles(unknowns, found, &at_bound, &blocks, &covariance);
    let known = combinations::of(unknowns, found, &covariance, &at_bound);
    let mut covariance = covariance.alone(&at_bound);
    let (mut estimates, columns) = estimates(problem, unknowns, found, &bounds, &covariance);
    let place = |row: &usize| columns.iter().position(|c| *c == Some(*row));
    let rows: Vec<usize> = covariance.rows.iter().filter_map(place).collect();
    let combinations = combinations::named(known, place);
    for estimate in estimates.iter_mut().filter(|e| e.at_bound.is_some()) {
        let is_it = |u: &Unknown| {
            problem.specs[u.parameter].parameter.name == estimate.name
                && estimate
                    .experiment
                    .is_none_or(|own| u.experiment == Some(own))
        };
        let column = unknowns.list.iter().position(is_it);
        let Some(column) = column else { continue };
        (estimate.profile, estimate.beyond) = ends[column];
        // The others may make up for any other value of it.
        if covariance.traded.contains(&column) {
            (estimate.profile, estimate.identifiable) = (f64::NAN, false);
        }
    }
    let correlation = correlation(&covariance.white);
    intervals::leave_open_correlated(problem, &rows, &correlation, &mut estimates);
    if let Some(case) = solution.no_better_than {
        leave_open_beyond(problem, case, &mut estimates);
    }
    let residuals = experiments.iter().flat_map(|e| &e.residual_deg);
    let samples = residuals.filter(|r| !r.is_nan()).count();
    intervals::include_misfit(misfit.ratio, samples, &mut covariance);
    for (row, &index) in rows.iter().enumerate() {
        estimates[index].standard_error_coloured = covariance.coloured[(row, row)].max(0.0).sqrt();
    }
    Fit {
        model: problem.model.name(),
        rows,
        combinations,
        estimates,
        correlation,
        consistency,
        covariance: covariance.white,
        covariance_coloured: covariance.coloured,
        loss: loss_of(problem),
        cost: found.cost,
        samples,
        misfit,
        noise_deg: covariance.noise_deg,
        fit_percent: overall(problem, &experiments),
        experiments,
        iterations: found.iterations,
        termination: found.termination,
        starts: solution.starts,
        no_better_than: solution.no_better_than,
        assumptions: solution.assumptions,
        delay_open_s: solution.delay_open_s,
        is_hold_undetermined: !solution.hold_differences.is_empty(),
    }
}

/// The loss of all runs.
fn loss_of(problem: &Problem) -> Loss {
    problem
        .experiments
        .first()
        .map_or(Loss::Squares, |run| run.loss)
}

/// Marks the additional parameters as not identifiable where a nested model fits as well.
fn leave_open_beyond(problem: &Problem, case: &str, estimates: &mut [Estimate]) {
    let cases = problem.model.nested_models();
    let Some(case) = cases.iter().find(|c| c.name() == case) else {
        return;
    };
    for estimate in estimates.iter_mut().filter(|e| !e.fixed) {
        estimate.identifiable &= !case.is_fixed_by_default(estimate.name);
    }
}

/// The bound that an unknown is at.
fn bound(unknowns: &Unknowns, index: usize, value: f64) -> Option<Bound> {
    let unknown = &unknowns.list[index];
    if value <= unknown.low {
        Some(Bound::Low)
    } else if value >= unknown.high {
        Some(Bound::High)
    } else {
        None
    }
}

fn correlation(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(covariance.nrows(), covariance.ncols(), |i, j| {
        covariance[(i, j)] / (covariance[(i, i)] * covariance[(j, j)]).sqrt()
    })
}

/// All estimates, and the unknown that each is of.
fn estimates(
    problem: &Problem,
    unknowns: &Unknowns,
    found: &Found,
    bounds: &[Option<Bound>],
    covariance: &Covariance,
) -> (Vec<Estimate>, Vec<Option<usize>>) {
    let mut estimates: Vec<Estimate> = Vec::new();
    let mut columns: Vec<Option<usize>> = Vec::new();
    for (parameter, spec) in problem.specs.iter().enumerate() {
        let is_it = |(_, u): &(usize, &Unknown)| u.parameter == parameter;
        let mut looked_for = unknowns.list.iter().enumerate().filter(is_it).peekable();
        if looked_for.peek().is_none() {
            estimates.extend(given(problem, parameter, spec));
            columns.resize(estimates.len(), None);
            continue;
        }
        for (column, unknown) in looked_for {
            let is_alone = problem.experiments.len() == 1;
            let mut estimate = plain(spec, found.point[column]);
            estimate.experiment = unknown.experiment.filter(|_| !is_alone);
            estimate.start = unknown.start;
            estimate.bounds = (unknown.low, unknown.high);
            estimate.fixed = false;
            estimate.at_bound = bounds[column];
            if let Some(row) = covariance.rows.iter().position(|r| *r == column) {
                estimate.standard_error = covariance.white[(row, row)].sqrt();
                estimate.standard_error_coloured = covariance.coloured[(row, row)].max(0.0).sqrt();
            }
            estimate.identifiable = is_identifiable(spec, &estimate);
            estimates.push(estimate);
            columns.push(Some(column));
        }
    }
    (estimates, columns)
}

/// A fixed value.
fn plain(spec: &Spec, value: f64) -> Estimate {
    Estimate {
        name: spec.parameter.name,
        unit: spec.parameter.unit,
        experiment: None,
        value,
        start: value,
        bounds: (spec.low, spec.high),
        fixed: true,
        standard_error: f64::NAN,
        standard_error_coloured: f64::NAN,
        at_bound: None,
        identifiable: true,
        profile: f64::NAN,
        beyond: 0.0,
    }
}

/// A fixed parameter, for all runs or run by run.
fn given(problem: &Problem, parameter: usize, spec: &Spec) -> Vec<Estimate> {
    let name = problem.specs[parameter].parameter.name;
    let known = |run: usize| problem.experiments[run].recording.constants.get(name);
    let values: Vec<f64> = (0..problem.experiments.len())
        .map(|run| known(run).copied().unwrap_or(spec.start))
        .collect();
    if values.iter().all(|v| v.to_bits() == values[0].to_bits()) {
        return vec![plain(spec, values[0])];
    }
    let one = |(run, value): (usize, &f64)| Estimate {
        experiment: Some(run),
        ..plain(spec, *value)
    };
    values.iter().enumerate().map(one).collect()
}

/// Whether the data determine a parameter.
fn is_identifiable(spec: &Spec, estimate: &Estimate) -> bool {
    if let Some(bound) = estimate.at_bound {
        // A delay or a damping of zero is a result; a pole at its upper bound is not.
        return bound == Bound::Low && estimate.bounds.0 == 0.0;
    }
    let error = estimate
        .standard_error
        .max(estimate.standard_error_coloured);
    // Parameters without influence have NaN as their standard error.
    !error.is_nan()
        && (!spec.has_scale() || spec.scope == Scope::Own || error <= VAGUE * estimate.value.abs())
}

/// Predictions and residuals of all experiments.
pub fn fits(problem: &Problem, unknowns: &Unknowns, point: &[f64]) -> Vec<ExperimentFit> {
    let runs = unknowns.runs.iter().enumerate();
    runs.map(|(i, run)| experiment_fit(problem, i, &run.values(point)))
        .collect()
}

/// Prediction and residuals of one experiment.
pub fn experiment_fit(problem: &Problem, experiment: usize, values: &[f64]) -> ExperimentFit {
    let run = &problem.experiments[experiment];
    let angles = &run.recording.angle_deg;
    let mut fit = ExperimentFit {
        name: run.recording.name.clone(),
        predicted_deg: vec![f64::NAN; run.len()],
        residual_deg: vec![f64::NAN; run.len()],
        state: vec![ActiveLimit::Free; run.len()],
        ..Default::default()
    };
    problem.model.simulate(run, values, &mut |i, sample| {
        fit.predicted_deg[i] = sample.angle_deg;
        fit.residual_deg[i] = angles[i] - sample.angle_deg;
        fit.state[i] = sample.state;
    });
    let (errors, spread) = squares(angles, &fit.residual_deg);
    fit.fit_percent = percent(errors, spread);
    let is_outlier = |i: &usize| run.loss.of(fit.residual_deg[*i]).1 < OUTLIER_WEIGHT;
    fit.outliers = (0..run.len()).filter(is_outlier).collect();
    fit.rate_limited_s = Limited::of(&run.recording.time_s, &fit.state).rate_limited_s();
    fit
}

/// Squares of the residuals, and of the angles around their mean.
fn squares(angles: &[f64], residuals: &[f64]) -> (f64, f64) {
    let compared = || residuals.iter().zip(angles).filter(|(r, _)| !r.is_nan());
    let count = compared().count() as f64;
    let mean = compared().map(|(_, a)| a).sum::<f64>() / count;
    let errors = compared().map(|(r, _)| r * r).sum();
    let spread = compared().map(|(_, a)| (a - mean).powi(2)).sum();
    (errors, spread)
}

fn percent(errors: f64, spread: f64) -> f64 {
    100.0 * (1.0 - (errors / spread).sqrt())
}

/// The fit over all experiments, each around its own mean.
fn overall(problem: &Problem, experiments: &[ExperimentFit]) -> f64 {
    let runs = problem.experiments.iter().zip(experiments);
    let sums = runs.map(|(run, fit)| squares(&run.recording.angle_deg, &fit.residual_deg));
    let (errors, spread) = sums.fold((0.0, 0.0), |(e, s), (errors, spread)| {
        (e + errors, s + spread)
    });
    percent(errors, spread)
}
