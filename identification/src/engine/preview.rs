//! A problem that is quicker than the one that is asked for, to find good starts in.

use rayon::prelude::*;

use super::{Options, starts};
use crate::experiment::Experiment;
use crate::levenberg::{Limits, search};
use crate::normal::cost;
use crate::problem::Problem;
use crate::unknowns::Unknowns;

/// More samples than this are thinned until the best start is known.
pub const MANY_SAMPLES: usize = 20_000;

/// Where the cost has many dips, so many points are looked at for each start, half of them around
/// the first look and half around where the special cases fit best.
const LOOKS_PER_START: usize = 12;

/// How far around: half of the sizes are within a factor of 3, nearly all within 20.
const SPREAD: f64 = 1.5;

/// So many of them for each start go a few steps down before it is said which are good.
const TRIED_PER_START: usize = 4;
const TRIED: Limits = Limits {
    iterations: 5,
    decrease: 1e-3,
};

/// So many searches of the preview go on in the problem itself, if its cost has many dips.
const FINALISTS: usize = 3;

/// How exactly the preview of such a model is searched.
const ROUGH: Limits = Limits {
    iterations: 60,
    decrease: 1e-5,
};

/// A preview of a problem.
pub struct Preview {
    pub problem: Problem,
    /// How exactly it is worth being searched.
    pub limits: Limits,
    /// How many of its searches are worth going on with.
    pub finalists: usize,
    /// Whether it has fewer samples.
    pub is_thinned: bool,
}

impl Preview {
    /// With fewer samples where there are many, in longer steps where the model's cost is rough.
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

    /// Of many points around two centres those from which a few steps lead lowest, as many as there
    /// are starts.
    pub fn promising(
        &self,
        unknowns: &Unknowns,
        centres: [&[f64]; 2],
        options: &Options,
        is_stopped: &(dyn Fn() -> bool + Sync),
    ) -> Vec<Vec<f64>> {
        let look = |index: usize| {
            let at = (options.seed, index);
            let point = starts::scattered(unknowns, centres[index % 2], SPREAD, at);
            let cost = match is_stopped() {
                true => f64::NAN,
                false => cost(&self.problem, unknowns, &point),
            };
            (cost, point)
        };
        let looks = (0..LOOKS_PER_START * options.starts).into_par_iter();
        let seen = least(looks.map(look).collect(), TRIED_PER_START * options.starts);
        let tried = |point: &Vec<f64>| {
            let found = search(&self.problem, unknowns, point, &TRIED, is_stopped)?;
            Some((found.cost, found.point))
        };
        least(seen.par_iter().filter_map(tried).collect(), options.starts)
    }
}

/// Of points with their costs the `count` that cost least.
fn least(mut points: Vec<(f64, Vec<f64>)>, count: usize) -> Vec<Vec<f64>> {
    points.retain(|(cost, _)| cost.is_finite());
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points.truncate(count);
    points.into_iter().map(|(_, point)| point).collect()
}
