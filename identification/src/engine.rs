//! The complete search: many starting points, the best optimum, and its statistics.

mod assumptions;
mod asynchronous;
mod combinations;
mod drift;
mod intervals;
mod likelihood_ratio;
mod nested;
mod outcome;
mod preview;
mod robust;
mod scouts;
mod starts;

use rayon::prelude::*;

use super::experiment::{Assumptions, Experiment};
use super::experiment_fit::ExperimentFit;
use super::fit::Fit;
use super::levenberg::{Found, Limits, search};
use super::loss::LossChoice;
use super::normal::{Normal, normal};
use super::problem::{IdentifyError, Problem, Role, Scope};
use super::unknowns::Unknowns;
use preview::Preview;

/// Options of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Number of starting points: the problem's, the one estimated from the data, and random ones
    /// around these.
    pub starts: usize,
    /// Seed of the random starting points.
    pub seed: u64,
    /// Termination criteria of each search.
    pub limits: Limits,
    /// How residuals count.
    pub loss: LossChoice,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            starts: 8,
            seed: 0,
            limits: Limits::default(),
            loss: LossChoice::default(),
        }
    }
}

/// Receives the progress of a search, and may stop it.
pub trait Progress: Sync {
    /// Called after each start, with the lowest cost so far, deg^2.
    fn done(&self, _done: usize, _of: usize, _best_cost: f64) {}

    /// Whether to stop with the best result so far.
    fn is_stopped(&self) -> bool {
        false
    }
}

/// Reports no progress.
#[derive(Debug, Clone, Copy, Default)]
pub struct Quiet;

impl Progress for Quiet {}

/// Fits a model to recordings.
///
/// # Errors
/// [`IdentifyError`]; a poor fit is not an error.
pub fn fit(
    problem: &Problem,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Fit, IdentifyError> {
    fit_from(problem, options, progress, &[])
}

/// The same with additional starting points: `known` contains fits to the same recordings of nested
/// models, or of the model with more of its parameters fixed. Other fits are ignored.
///
/// # Errors
/// Those of [`fit`].
pub fn fit_from(
    problem: &Problem,
    options: &Options,
    progress: &dyn Progress,
    known: &[&Fit],
) -> Result<Fit, IdentifyError> {
    let given = match options.loss {
        LossChoice::Given(loss) => Some(problem.with_loss(loss)),
        _ => None,
    };
    let problem = given.as_ref().unwrap_or(problem);
    let usual = solve(problem, options, progress, known)?;
    let (other, solution) = assumptions::decided(problem, usual, options, progress, known)?;
    let problem = other.as_ref().unwrap_or(problem);
    let (other, mut solution) = asynchronous::decided(problem, solution, options, progress);
    let problem = other.as_ref().unwrap_or(problem);
    let is_robust = match options.loss {
        LossChoice::Auto => robust::is_called_for(problem, &solution),
        LossChoice::Robust => true,
        LossChoice::Squares | LossChoice::Given(_) => false,
    };
    let mut other = None;
    if is_robust {
        let (at, found) = robust::solve(problem, solution.clone(), options, progress, known)?;
        let is_required = options.loss == LossChoice::Robust;
        if is_required || !robust::is_worse(problem, &solution, (&at, &found)) {
            (other, solution) = (Some(at), found);
        }
    }
    let problem = other.as_ref().unwrap_or(problem);
    let (unknowns, found) = (&solution.unknowns, solution.found);
    let is_stopped = || progress.is_stopped();
    solution.found = likelihood_ratio::without_insignificant_limits(
        problem,
        unknowns,
        found,
        &options.limits,
        &is_stopped,
    );
    let (found, neglected) = likelihood_ratio::without_negligible_effects(
        problem,
        &solution,
        &options.limits,
        &is_stopped,
    );
    solution.found = found;
    Ok(outcome::fit(problem, &solution, &neglected))
}

/// The optimum of a model.
#[derive(Clone)]
struct Solution {
    unknowns: Unknowns,
    found: Found,
    /// Number of searches, and how many of them ended there.
    starts: (usize, usize),
    /// The assumptions about the recordings.
    assumptions: Assumptions,
    /// Where a zero-order hold of the command fits as well as a smooth command: how far from each
    /// unknown its value for the hold is; otherwise empty.
    hold_differences: Vec<f64>,
    /// Where the command may have changed before the samples that show it: how far below and above
    /// the estimate the delay may be for that reason, s.
    delay_open_s: Option<(f64, f64)>,
    /// The nested model that fits as well by a likelihood-ratio test.
    no_better_than: Option<&'static str>,
}

fn solve(
    problem: &Problem,
    options: &Options,
    progress: &dyn Progress,
    known: &[&Fit],
) -> Result<Solution, IdentifyError> {
    let unknowns = Unknowns::of(problem)?;
    let preview = Preview::of(problem, &options.limits);
    let thinned = preview.as_ref().filter(|preview| preview.is_thinned);
    let where_to_nest = thinned.map_or(problem, |preview| &preview.problem);
    let nested = nested::starts(where_to_nest, &unknowns, options, progress, known);
    let descent = Searches {
        problem,
        unknowns: &unknowns,
        limits: options.limits,
        progress,
    };
    if options.starts <= 1 && nested.is_empty() {
        let found = descent
            .one(&unknowns.start())
            .ok_or(IdentifyError::NotFinite)?;
        return Ok(Solution {
            unknowns,
            found,
            starts: (1, 1),
            assumptions: Assumptions::default(),
            hold_differences: Vec::new(),
            delay_open_s: None,
            no_better_than: None,
        });
    }
    let points: Vec<Vec<f64>> = nested.iter().map(|nested| nested.point.clone()).collect();
    let starts = all_starts(
        problem,
        &unknowns,
        options,
        progress,
        (&points, preview.as_ref()),
    );
    let Some(preview) = preview else {
        let (found, starts) = scouts::best(&descent, &starts)?;
        return Ok(Solution {
            starts,
            found,
            unknowns,
            assumptions: Assumptions::default(),
            hold_differences: Vec::new(),
            delay_open_s: None,
            no_better_than: None,
        });
    };
    let quick = Searches {
        problem: &preview.problem,
        limits: preview.limits,
        ..descent
    };
    let candidates = quick.each(&starts)?;
    let share = share(&candidates);
    let finalists = candidates.into_iter().take(preview.finalists);
    let mut finalists: Vec<Vec<f64>> = finalists.map(|found| found.point).collect();
    // The preview's optimum may differ: starting at the nested optimum, the fit is never worse than
    // it.
    finalists.extend(points);
    let cancel_only = nested::CancelOnly(progress);
    let last = Searches {
        progress: &cancel_only,
        ..descent
    };
    let found = first(last.each(&finalists)?)?;
    let (found, no_better_than) =
        likelihood_ratio::reduced_to_nested(problem, &unknowns, found, &nested);
    Ok(Solution {
        unknowns,
        found,
        starts: share,
        assumptions: Assumptions::default(),
        hold_differences: Vec::new(),
        delay_open_s: None,
        no_better_than,
    })
}

/// The starting points: the given ones, those estimated from the data, the optima of nested models,
/// and random points around these.
fn all_starts(
    problem: &Problem,
    unknowns: &Unknowns,
    options: &Options,
    progress: &dyn Progress,
    (nested, preview): (&[Vec<f64>], Option<&Preview>),
) -> Vec<Vec<f64>> {
    let mut all = vec![unknowns.start()];
    if options.starts > 1 {
        all = starts::given_and_estimated(problem, unknowns);
        let centre = all[all.len() - 1].clone();
        if let Some(preview) = preview.filter(|_| problem.model.has_many_minima()) {
            let centres = [&centre, nested.last().unwrap_or(&centre)].map(Vec::as_slice);
            let is_stopped = || progress.is_stopped();
            all.extend(preview.best_points(unknowns, centres, options, &is_stopped));
        } else {
            let around = all.len()..options.starts;
            all.extend(
                around.map(|i| starts::scattered(unknowns, &centre, 1.0, (options.seed, i))),
            );
        }
    }
    all.extend_from_slice(nested);
    all
}

/// Local searches of one problem.
#[derive(Clone, Copy)]
struct Searches<'a> {
    problem: &'a Problem,
    unknowns: &'a Unknowns,
    limits: Limits,
    progress: &'a dyn Progress,
}

impl Searches<'_> {
    fn one(&self, start: &[f64]) -> Option<Found> {
        let is_stopped = || self.progress.is_stopped();
        search(
            self.problem,
            self.unknowns,
            start,
            &self.limits,
            &is_stopped,
        )
    }

    /// Searches from each of several starting points; returns the optima, best first.
    fn each(&self, starts: &[Vec<f64>]) -> Result<Vec<Found>, IdentifyError> {
        self.each_by(starts, |start| self.one(start))
    }

    /// The same by any search. After a request to stop only the first one is still begun, so that
    /// there is a result.
    fn each_by(
        &self,
        starts: &[Vec<f64>],
        search: impl Fn(&[f64]) -> Option<Found> + Sync,
    ) -> Result<Vec<Found>, IdentifyError> {
        let state = std::sync::Mutex::new((0, f64::INFINITY));
        let one = |(index, start): (usize, &Vec<f64>)| {
            if index > 0 && self.progress.is_stopped() {
                return None;
            }
            let found = search(start);
            let cost = found.as_ref().map_or(f64::INFINITY, |f| f.cost);
            if let Ok(mut state) = state.lock() {
                *state = (state.0 + 1, state.1.min(cost));
                self.progress.done(state.0, starts.len(), state.1);
            }
            found
        };
        let mut found: Vec<Found> = starts.par_iter().enumerate().filter_map(one).collect();
        found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        match found.is_empty() {
            true => Err(IdentifyError::NotFinite),
            false => Ok(found),
        }
    }
}

fn first(found: Vec<Found>) -> Result<Found, IdentifyError> {
    found.into_iter().next().ok_or(IdentifyError::NotFinite)
}

/// Number of searches, and how many of them ended at the cost of the first, which is the best.
fn share(found: &[Found]) -> (usize, usize) {
    let best = found.first().map_or(f64::NAN, |f| f.cost);
    let same = |f: &&Found| is_same_cost(f.cost, best);
    (found.len(), found.iter().filter(same).count())
}

/// Whether a cost is the lowest one: a millionth of it is a thousandth of a standard error and
/// less.
fn is_same_cost(cost: f64, lowest: f64) -> bool {
    cost <= lowest * (1.0 + 1e-6)
}

/// Cost, gradient and Gauss-Newton matrix at a point: the information of the experiments. The
/// unknowns are the free parameters in the order of the model; those with a value for each
/// experiment occur once for each.
///
/// # Errors
/// Those of [`Unknowns::of`].
pub fn normal_equations(problem: &Problem, point: &[f64]) -> Result<Normal, IdentifyError> {
    Ok(normal(problem, &Unknowns::of(problem)?, point))
}

/// The prediction of a recording that the model was not fitted to: the parameters are fixed, and
/// only the initial state is estimated.
///
/// # Errors
/// Those of [`fit`].
pub fn predict(
    problem: &Problem,
    fitted: &Fit,
    experiment: &Experiment,
) -> Result<ExperimentFit, IdentifyError> {
    let under = |begins_at_rest: bool| {
        let assumptions = Assumptions {
            begins_at_rest,
            ..fitted.assumptions
        };
        predict_as_read(problem, fitted, experiment.under(assumptions))
    };
    let usual = under(false)?;
    if !assumptions::may_begin_at_rest(experiment) {
        return Ok(usual);
    }
    let at_rest = under(true)?;
    let is_closer = at_rest.fit_percent > usual.fit_percent;
    Ok(if is_closer { at_rest } else { usual })
}

fn predict_as_read(
    problem: &Problem,
    fitted: &Fit,
    experiment: Experiment,
) -> Result<ExperimentFit, IdentifyError> {
    let mut held = Problem::try_new(problem.model.clone(), vec![experiment])?;
    for (index, spec) in held.specs.iter_mut().enumerate() {
        let requested = &problem.specs[index];
        spec.scope = Scope::Own;
        if problem.model.parameters()[index].is_initial_state {
            spec.role = requested.role;
        } else {
            spec.role = Role::Fixed;
            spec.start = fitted.value(spec.parameter.name).unwrap_or(requested.start);
        }
    }
    match Unknowns::of(&held) {
        Ok(unknowns) => {
            let start = unknowns.start();
            let found = search(&held, &unknowns, &start, &Limits::default(), &|| false);
            let found = found.ok_or(IdentifyError::NotFinite)?;
            let values = unknowns.runs[0].values(&found.point);
            Ok(outcome::experiment_fit(&held, 0, &values))
        }
        Err(IdentifyError::NothingFree) => {
            let start: Vec<f64> = held.specs.iter().map(|s| s.start).collect();
            Ok(outcome::experiment_fit(&held, 0, &start))
        }
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests;
