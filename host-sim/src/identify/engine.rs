//! The search as a whole: many starts, the best of them, and what is to be said of it.

mod nested;
mod outcome;
mod release;

use rayon::prelude::*;

use super::experiment::Experiment;
use super::fit::{ExperimentFit, Fit};
use super::levenberg::{Found, Limits, search};
use super::normal::{Normal, normal};
use super::problem::{IdentifyError, Problem, Role, Scope};
use super::unknowns::Unknowns;
use model_core::sensors::noise::Noise;

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

/// More samples than this are thinned until the best start is known.
const MANY_SAMPLES: usize = 40_000;

/// Fits a model to recordings.
///
/// # Errors
/// [`IdentifyError`] for what cannot be fitted; a poor fit is none.
pub fn fit(
    problem: &Problem,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Fit, IdentifyError> {
    let (unknowns, found, share) = solve(problem, options, progress)?;
    let is_stopped = || progress.is_stopped();
    let found = release::needless_limits(problem, &unknowns, found, &options.limits, &is_stopped);
    Ok(outcome::fit(problem, &unknowns, &found, share))
}

/// The unknowns, where they fit best, how many searches there were, and how many ended there.
type Solution = (Unknowns, Found, (usize, usize));

fn solve(
    problem: &Problem,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Solution, IdentifyError> {
    let unknowns = Unknowns::of(problem)?;
    let mut starts = starts(problem, &unknowns, options);
    if starts.len() > 1 {
        starts.extend(nested::starts(problem, &unknowns, options, progress)?);
    }
    let samples: usize = problem.experiments.iter().map(Experiment::len).sum();
    let every = samples.div_ceil(MANY_SAMPLES);
    let (point, share) = if starts.len() == 1 {
        (starts.swap_remove(0), (1, 1))
    } else if every > 1 {
        let thinned = problem.experiments.iter().map(|e| e.thinned(every));
        let thinned = problem.with_experiments(thinned.collect());
        let (best, share) = best(&thinned, &unknowns, &starts, options, progress)?;
        (best.point, share)
    } else {
        let (best, share) = best(problem, &unknowns, &starts, options, progress)?;
        return Ok((unknowns, best, share));
    };
    let is_stopped = || progress.is_stopped();
    let found = search(problem, &unknowns, &point, &options.limits, &is_stopped);
    let found = found.ok_or(IdentifyError::NotFinite)?;
    Ok((unknowns, found, share))
}

/// The best of several searches, how many there were, and how many ended at its cost.
fn best(
    problem: &Problem,
    unknowns: &Unknowns,
    starts: &[Vec<f64>],
    options: &Options,
    progress: &dyn Progress,
) -> Result<(Found, (usize, usize)), IdentifyError> {
    let state = std::sync::Mutex::new((0, f64::INFINITY));
    let is_stopped = || progress.is_stopped();
    let one = |start: &Vec<f64>| {
        let found = search(problem, unknowns, start, &options.limits, &is_stopped);
        let cost = found.as_ref().map_or(f64::INFINITY, |f| f.cost);
        if let Ok(mut state) = state.lock() {
            *state = (state.0 + 1, state.1.min(cost));
            progress.done(state.0, starts.len(), state.1);
        }
        found
    };
    let found: Vec<Found> = starts.par_iter().filter_map(one).collect();
    let least = found.iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
    let best = least.ok_or(IdentifyError::NotFinite)?.clone();
    // A millionth of the cost is a thousandth of a standard error and less.
    let same = |f: &&Found| f.cost <= best.cost * (1.0 + 1e-6);
    let count = found.iter().filter(same).count();
    Ok((best, (starts.len(), count)))
}

/// Where the searches begin: at the problem's start, at that of a first look, and around both.
fn starts(problem: &Problem, unknowns: &Unknowns, options: &Options) -> Vec<Vec<f64>> {
    let given = unknowns.start();
    let mut starts = vec![given.clone()];
    if options.starts <= 1 {
        return starts;
    }
    let look = problem.model.start(&problem.experiments);
    let from_look = |(u, given): (&super::unknowns::Unknown, &f64)| {
        let value = look[u.parameter];
        if u.experiment.is_some() || !value.is_finite() {
            *given
        } else {
            value.clamp(u.low, u.high)
        }
    };
    let looked: Vec<f64> = unknowns.list.iter().zip(&given).map(from_look).collect();
    if looked != given {
        starts.push(looked.clone());
    }
    for index in starts.len()..options.starts {
        let mut noise = Noise::new(options.seed, index as u64);
        let scatter = |(u, centre): (&super::unknowns::Unknown, &f64)| {
            // Half of the starts are within a factor of 2 of a size, nearly all within 8.
            let number = noise.gaussian(1.0);
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
        starts.push(unknowns.list.iter().zip(&looked).map(scatter).collect());
    }
    starts
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
    let mut held = Problem::try_new(problem.model.clone(), vec![experiment.clone()])?;
    for (index, spec) in held.specs.iter_mut().enumerate() {
        let asked = &problem.specs[index];
        spec.scope = Scope::Own;
        if problem.model.is_of_the_run(index) {
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
