//! The search as a whole: many starts, the best of them, and what is to be said of it.

mod nested;
mod outcome;
mod preview;
mod reading;
mod release;
mod starts;

use rayon::prelude::*;

use super::experiment::{Experiment, Reading};
use super::fit::{ExperimentFit, Fit};
use super::levenberg::{Found, Limits, search};
use super::normal::{Normal, normal};
use super::problem::{IdentifyError, Problem, Role, Scope};
use super::unknowns::Unknowns;
use preview::Preview;

/// How to search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Starts: the one of the problem, the one of a first look, and others scattered around them.
    pub starts: usize,
    /// Seed of the scatter.
    pub seed: u64,
    /// When each search ends.
    pub limits: Limits,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            starts: 8,
            seed: 0,
            limits: Limits::default(),
        }
    }
}

/// Is told how far the search is, and may stop it.
pub trait Progress: Sync {
    /// So many of so many starts are done; the least cost so far, deg^2.
    fn done(&self, _done: usize, _of: usize, _best_cost: f64) {}

    /// Whether to stop with the best that there is.
    fn is_stopped(&self) -> bool {
        false
    }
}

/// Tells nobody.
#[derive(Debug, Clone, Copy, Default)]
pub struct Quiet;

impl Progress for Quiet {}

/// Fits a model to recordings.
///
/// # Errors
/// [`IdentifyError`] for what cannot be fitted; a poor fit is none.
pub fn fit(
    problem: &Problem,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Fit, IdentifyError> {
    fit_from(problem, options, progress, &[])
}

/// The same, beginning also where simpler models fit best: `known` holds fits of special cases of the
/// model, or of the model with more of its parameters held, to the same recordings. Others are
/// passed over.
///
/// # Errors
/// Those of [`fit`].
pub fn fit_from(
    problem: &Problem,
    options: &Options,
    progress: &dyn Progress,
    known: &[&Fit],
) -> Result<Fit, IdentifyError> {
    let usual = solve(problem, options, progress, known)?;
    let (other, mut solution) = reading::decided(problem, usual, options, progress, known)?;
    let problem = other.as_ref().unwrap_or(problem);
    let (unknowns, found) = (&solution.unknowns, solution.found);
    let is_stopped = || progress.is_stopped();
    solution.found =
        release::needless_limits(problem, unknowns, found, &options.limits, &is_stopped);
    Ok(outcome::fit(problem, &solution))
}

/// Where a model fits best.
struct Solution {
    unknowns: Unknowns,
    found: Found,
    /// How many searches there were, and how many ended there.
    starts: (usize, usize),
    /// How the recordings are read.
    reading: Reading,
    /// Whether the command may be held as well as smooth.
    is_hold_open: bool,
    /// The special case that fits as well but for chance.
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
    let descent = Descent {
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
            reading: Reading::default(),
            is_hold_open: false,
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
        let found = descent.each(&starts)?;
        return Ok(Solution {
            starts: share(&found),
            found: first(found)?,
            unknowns,
            reading: Reading::default(),
            is_hold_open: false,
            no_better_than: None,
        });
    };
    let quick = Descent {
        problem: &preview.problem,
        limits: preview.limits,
        ..descent
    };
    let seen = quick.each(&starts)?;
    let share = share(&seen);
    let finalists = seen.into_iter().take(preview.finalists);
    let mut finalists: Vec<Vec<f64>> = finalists.map(|found| found.point).collect();
    // What the preview makes of a case is not what the problem does: no worse than the case.
    finalists.extend(points);
    let silent = nested::Silent(progress);
    let last = Descent {
        progress: &silent,
        ..descent
    };
    let found = first(last.each(&finalists)?)?;
    let (found, no_better_than) = release::needless_rest(problem, &unknowns, found, &nested);
    Ok(Solution {
        unknowns,
        found,
        starts: share,
        reading: Reading::default(),
        is_hold_open: false,
        no_better_than,
    })
}

/// Where the searches begin: where somebody or a first look says, where special cases fit best, and
/// at points around these.
fn all_starts(
    problem: &Problem,
    unknowns: &Unknowns,
    options: &Options,
    progress: &dyn Progress,
    (nested, preview): (&[Vec<f64>], Option<&Preview>),
) -> Vec<Vec<f64>> {
    let mut all = vec![unknowns.start()];
    if options.starts > 1 {
        all = starts::sure(problem, unknowns);
        let centre = all[all.len() - 1].clone();
        if let Some(preview) = preview.filter(|_| problem.model.has_many_minima()) {
            let centres = [&centre, nested.last().unwrap_or(&centre)].map(Vec::as_slice);
            let is_stopped = || progress.is_stopped();
            all.extend(preview.promising(unknowns, centres, options, &is_stopped));
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

/// Searches of one problem.
#[derive(Clone, Copy)]
struct Descent<'a> {
    problem: &'a Problem,
    unknowns: &'a Unknowns,
    limits: Limits,
    progress: &'a dyn Progress,
}

impl Descent<'_> {
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

    /// From each of several starts, the best first. Once somebody wishes to stop, none is begun but
    /// the first: what there is then is the answer.
    fn each(&self, starts: &[Vec<f64>]) -> Result<Vec<Found>, IdentifyError> {
        let state = std::sync::Mutex::new((0, f64::INFINITY));
        let one = |(index, start): (usize, &Vec<f64>)| {
            if index > 0 && self.progress.is_stopped() {
                return None;
            }
            let found = self.one(start);
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

/// How many searches there were, and how many ended at the cost of the first, which is the best.
fn share(found: &[Found]) -> (usize, usize) {
    let best = found.first().map_or(f64::NAN, |f| f.cost);
    // A millionth of the cost is a thousandth of a standard error and less.
    let same = |f: &&Found| f.cost <= best * (1.0 + 1e-6);
    (found.len(), found.iter().filter(same).count())
}

/// Cost, gradient and Gauss-Newton matrix at a point: the information that the experiments hold.
/// The unknowns are those parameters that are free, in the order of the model, with those that
/// belong to one experiment repeated for each.
///
/// # Errors
/// Those of [`Unknowns::of`].
pub fn normal_equations(problem: &Problem, point: &[f64]) -> Result<Normal, IdentifyError> {
    Ok(normal(problem, &Unknowns::of(problem)?, point))
}

/// What a fitted model says of a recording that it was not fitted to: its parameters are held, the
/// state at the first sample alone is looked for.
///
/// # Errors
/// Those of [`fit`].
pub fn predict(
    problem: &Problem,
    fitted: &Fit,
    experiment: &Experiment,
) -> Result<ExperimentFit, IdentifyError> {
    let read = |begins_at_rest: bool| {
        let reading = Reading {
            begins_at_rest,
            ..fitted.reading
        };
        predict_as_read(problem, fitted, experiment.read(reading))
    };
    let usual = read(false)?;
    if !reading::may_begin_at_rest(experiment) {
        return Ok(usual);
    }
    let at_rest = read(true)?;
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
        let asked = &problem.specs[index];
        spec.scope = Scope::Own;
        if problem.model.parameters()[index].is_initial_state {
            spec.role = asked.role;
        } else {
            spec.role = Role::Fixed;
            spec.start = fitted.value(spec.parameter.name).unwrap_or(asked.start);
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
