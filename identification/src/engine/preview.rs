//! A faster version of a problem, in which to find good starting points.

use rayon::prelude::*;

use super::{Options, starts};
use crate::experiment::Experiment;
use crate::levenberg::{Limits, search};
use crate::normal::cost;
use crate::problem::Problem;
use crate::unknowns::Unknowns;

/// Number of samples above which the preview uses only a part of them.
pub const MANY_SAMPLES: usize = 20_000;

/// For a model with many minima, the number of points that are evaluated for each start, half of
/// them around the estimated starting values and half around the optima of nested models.
const POINTS_PER_START: usize = 12;

/// Their spread: half of the logarithmic parameters are within a factor of 3, nearly all within 20.
const SPREAD: f64 = 1.5;

/// The number of them for each start that are improved by a few steps before the best are selected.
const IMPROVED_PER_START: usize = 4;
const IMPROVED: Limits = Limits {
    iterations: 5,
    decrease: 1e-3,
};

/// For a model with many minima, the number of optima of the preview that are continued in the
/// problem itself.
const FINALISTS: usize = 3;

/// Termination criteria of the preview of such a model.
const ROUGH: Limits = Limits {
    iterations: 60,
    decrease: 1e-5,
};

/// A preview of a problem.
pub struct Preview {
    pub problem: Problem,
    /// Termination criteria of its searches.
    pub limits: Limits,
    /// The number of its optima that are continued in the problem itself.
    pub finalists: usize,
    /// Whether it uses fewer samples.
    pub is_thinned: bool,
}

impl Preview {
    /// With fewer samples where there are many, and in longer steps for a model with many minima.
    pub fn of(problem: &Problem, limits: &Limits) -> Option<Self> {
        let samples: usize = problem.experiments.iter().map(Experiment::len).sum();
        let every = samples.div_ceil(MANY_SAMPLES);
        let is_rough = problem.model.has_many_minima();
        if every <= 1 && !is_rough {
            return None;
        }
        let quicker = problem.experiments.iter().map(|e| Experiment {
            is_preview: true,
            ..e.thinned(every)
        });
        let limits = match is_rough {
            true => Limits {
                iterations: ROUGH.iterations.min(limits.iterations),
                decrease: ROUGH.decrease.max(limits.decrease),
            },
            false => *limits,
        };
        Some(Self {
            problem: problem.with_experiments(quicker.collect()),
            limits,
            finalists: if every <= 1 { FINALISTS } else { 1 },
            is_thinned: every > 1,
        })
    }

    /// Random points around two centres, reduced to those with the lowest cost after a few steps.
    pub fn best_points(
        &self,
        unknowns: &Unknowns,
        centres: [&[f64]; 2],
        options: &Options,
        is_stopped: &(dyn Fn() -> bool + Sync),
    ) -> Vec<Vec<f64>> {
        let evaluated = |index: usize| {
            let at = (options.seed, index);
            let point = starts::scattered(unknowns, centres[index % 2], SPREAD, at);
            let cost = match is_stopped() {
                true => f64::NAN,
                false => cost(&self.problem, unknowns, &point),
            };
            (cost, point)
        };
        let points = (0..POINTS_PER_START * options.starts).into_par_iter();
        let best = least(
            points.map(evaluated).collect(),
            IMPROVED_PER_START * options.starts,
        );
        let improved = |point: &Vec<f64>| {
            let found = search(&self.problem, unknowns, point, &IMPROVED, is_stopped)?;
            Some((found.cost, found.point))
        };
        least(
            best.par_iter().filter_map(improved).collect(),
            options.starts,
        )
    }
}

/// The `count` points with the lowest cost.
fn least(mut points: Vec<(f64, Vec<f64>)>, count: usize) -> Vec<Vec<f64>> {
    points.retain(|(cost, _)| cost.is_finite());
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points.truncate(count);
    points.into_iter().map(|(_, point)| point).collect()
}
