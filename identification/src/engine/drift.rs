//! The drift between the clocks of command and angle, by fits with the instants of the angle
//! scaled.

use super::preview::MANY_SAMPLES;
use crate::blocks::Blocks;
use crate::consistency::{Drift, drift_step};
use crate::experiment::Experiment;
use crate::experiment_fit::ExperimentFit;
use crate::levenberg::{Found, Limits, search};
use crate::problem::Problem;
use crate::unknowns::Unknowns;

/// Fits with a scaled clock: the step from one to the next is that of Gauss and Newton.
const ROUNDS: usize = 4;
/// Their termination criteria: a drift is determined to a few digits.
const LIMITS: Limits = Limits {
    iterations: 20,
    decrease: 1e-4,
};
/// Errors of a drift, for white residuals, from which it is reported.
const SIGNIFICANT: f64 = 5.0;
/// The smallest drift that is reported: a quartz clock is ten times better.
const LEAST: f64 = 1e-3;
/// The largest: farther away, the Gauss-Newton step leads nowhere.
const MOST: f64 = 0.1;
/// Share of the cost that it explains at least. What a model lacks is seldom proportional to the
/// time.
const EXPLAINED: f64 = 0.2;

/// Drifts from which the search for one begins, where the Gauss-Newton step leads nowhere: a
/// response that is late by more than a step lasts has no slope towards its place.
const TRIED: [f64; 8] = [-0.04, -0.02, -0.01, -0.005, 0.005, 0.01, 0.02, 0.04];
/// Termination criteria of a trial.
const TRIAL: Limits = Limits {
    iterations: 6,
    decrease: 1e-2,
};
/// Mean square of the differences of successive residuals, in mean squares, below which residuals
/// are smooth and the model does not describe the recording; 2 of white ones (von Neumann, Annals
/// of Mathematical Statistics 12, 1941).
const SMOOTH: f64 = 1.0;

/// The drift at an optimum, if it explains much of the cost.
pub fn of(
    problem: &Problem,
    unknowns: &Unknowns,
    found: &Found,
    fits: &[ExperimentFit],
) -> Option<Drift> {
    // Searches of a model with many minima are slow, and friction resembles a changing delay.
    if problem.model.has_many_minima() || !are_smooth(fits) {
        return None;
    }
    let samples = problem
        .experiments
        .iter()
        .map(Experiment::len)
        .sum::<usize>();
    let every = samples.div_ceil(MANY_SAMPLES);
    let runs = problem.experiments.iter().map(|run| run.thinned(every));
    let plain = problem.with_experiments(runs.collect());
    let compared = samples.div_ceil(every) as f64;
    let deviation_deg = |cost: f64| (2.0 * cost / compared).sqrt();
    let near = |share: f64, from: &[f64], limits: &Limits| {
        let runs = plain.experiments.iter().map(|run| run.on_clock(share));
        let scaled = plain.with_experiments(runs.collect());
        let found = search(&scaled, unknowns, from, limits, &|| false)?;
        let blocks = Blocks::of(&scaled, unknowns, &found.point, &|residual| residual);
        let step = drift_step(&blocks, unknowns, deviation_deg(found.cost))?;
        Some((share, found, step))
    };
    let without = near(0.0, &found.point, &TRIAL)?;
    // Even the least drift would leave larger residuals: at the best values of all other unknowns
    // those of a drift `s` add up to `(s deviation/standard error)^2`.
    if LEAST > 2.0 * compared.sqrt() * without.2.standard_error {
        return None;
    }
    let first = without.2.share.clamp(-MOST, MOST);
    let tried = TRIED.into_iter().chain([first]);
    let tried = tried.filter_map(|share| near(share, &without.1.point, &TRIAL));
    let mut best = tried.min_by(|a, b| a.1.cost.total_cmp(&b.1.cost))?;
    for _ in 0..ROUNDS {
        let share = (best.0 + best.2.share).clamp(-MOST, MOST);
        let next = near(share, &best.1.point, &LIMITS)?;
        if next.1.cost >= best.1.cost {
            break;
        }
        best = next;
    }
    let (share, found, step) = best;
    // At the end of the range it is another property of the actuator that grows with the time.
    let is_told = share.abs() < MOST
        && found.cost < (1.0 - EXPLAINED) * without.1.cost
        && share.abs() > LEAST.max(SIGNIFICANT * step.standard_error);
    is_told.then_some(Drift {
        share,
        standard_error: step.standard_error,
    })
}

/// Whether the residuals are smooth.
fn are_smooth(fits: &[ExperimentFit]) -> bool {
    let (mut differences, mut squares) = (0.0, 0.0);
    for fit in fits {
        let residuals = fit.residual_deg.iter().copied();
        let present: Vec<f64> = residuals.filter(|r| !r.is_nan()).collect();
        differences += present
            .windows(2)
            .map(|w| (w[1] - w[0]).powi(2))
            .sum::<f64>();
        squares += present.iter().map(|r| r * r).sum::<f64>();
    }
    differences < SMOOTH * squares
}
