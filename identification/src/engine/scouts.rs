//! Searches from many starting points of which each optimum is followed to its end once.
//!
//! A search that is close to an optimum takes its last steps to digits that say nothing about which
//! optimum it is. So each search first ends where a full Gauss-Newton step predicts little more.
//! Two of them lead to the same optimum where the outputs of the model at their points differ by no
//! more than both are still expected to move.

use nalgebra::DVector;
use rayon::prelude::*;

use super::{Searches, is_same_cost};
use crate::levenberg::Termination;
use crate::levenberg::{Found, Limits, search_down_to};
use crate::problem::{IdentifyError, Problem};

/// Predicted decrease at which a search is close to an optimum, as a share of the cost: the
/// distance is a thousandth of the residuals, less than lies between the small minima of a model
/// whose modes begin and end with the samples.
const CLOSE: f64 = 1e-6;
/// The same as a share of the squares of the angle. Without noise the cost vanishes at the optimum,
/// and every step predicts a large share of it.
const CLOSE_OF_ANGLE: f64 = 1e-8;
/// Factor on predicted decreases, which are those of a linear model.
const SLACK: f64 = 10.0;

/// The best optimum, with the number of searches and how many of them led to it.
pub fn best(
    searches: &Searches<'_>,
    starts: &[Vec<f64>],
) -> Result<(Found, (usize, usize)), IdentifyError> {
    let (problem, limits) = (searches.problem, &searches.limits);
    let close = Limits {
        iterations: limits.iterations,
        decrease: limits.decrease.max(CLOSE),
    };
    let floor = CLOSE_OF_ANGLE * spread(problem);
    let is_stopped = || searches.progress.is_stopped();
    let candidates = searches.each_by(starts, |start| {
        let at = (problem, searches.unknowns);
        search_down_to(floor, at, start, &close, &is_stopped)
    })?;
    let count = candidates.len();
    let lowest = candidates[0].cost;
    let mut optima: Vec<(Found, usize)> = Vec::new();
    for candidate in candidates {
        let same = |(optimum, _): &&mut (Found, usize)| is_same(optimum, &candidate);
        match optima.iter_mut().find(same) {
            Some((_, starts)) => *starts += 1,
            None => optima.push((candidate, 1)),
        }
    }
    let may_be_best = |(found, _): &(Found, usize)| found.cost - SLACK * expected(found) <= lowest;
    optima.retain(may_be_best);
    let finished = |(found, starts)| (finished(searches, found), starts);
    let mut optima: Vec<(Found, usize)> = optima.into_par_iter().map(finished).collect();
    optima.sort_by(|a, b| a.0.cost.total_cmp(&b.0.cost));
    let cost = optima.first().map_or(f64::NAN, |(best, _)| best.cost);
    let at_best = optima
        .iter()
        .filter(|(found, _)| is_same_cost(found.cost, cost));
    let share = (count, at_best.map(|(_, starts)| starts).sum());
    let best = optima.into_iter().next();
    Ok((best.ok_or(IdentifyError::NotFinite)?.0, share))
}

/// The end of a search that ended close to an optimum.
fn finished(searches: &Searches<'_>, found: Found) -> Found {
    if found.termination != Termination::Converged {
        return found;
    }
    match searches.one(&found.point) {
        Some(end) if end.cost <= found.cost => Found {
            iterations: found.iterations + end.iterations,
            ..end
        },
        _ => found,
    }
}

/// The decrease that is still to be expected, deg^2: nothing of a search that did not get close.
fn expected(found: &Found) -> f64 {
    match found.termination {
        Termination::Converged => found.predicted.unwrap_or(0.0).max(0.0),
        _ => 0.0,
    }
}

/// Whether two searches lead to the same optimum. `sqrt(2 decrease)` is the norm by which the
/// output still changes.
fn is_same(a: &Found, b: &Found) -> bool {
    let between = DVector::from_vec(a.point.clone()) - DVector::from_column_slice(&b.point);
    let apart = 0.5 * between.dot(&(&a.information * &between));
    let reach = expected(a).sqrt() + expected(b).sqrt();
    apart <= SLACK * reach * reach
}

/// Half the sum of the squares of the angles around the mean of their recording, deg^2.
fn spread(problem: &Problem) -> f64 {
    let of_run = |angles: &[f64]| {
        let present = || angles.iter().filter(|angle| !angle.is_nan());
        let mean = present().sum::<f64>() / present().count().max(1) as f64;
        0.5 * present().map(|angle| (angle - mean).powi(2)).sum::<f64>()
    };
    let runs = problem.experiments.iter();
    runs.map(|run| of_run(&run.recording.angle_deg)).sum()
}
