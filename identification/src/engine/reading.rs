//! What a recording does not say of its command, decided by what fits.
//!
//! A command that moves from sample to sample may be a smooth curve or held between its samples: half a sample
//! of delay lies between the two. One that is not at rest at the first sample may have been so for long,
//! or have come that moment to an actuator at rest, as where a recording is triggered by its step: then
//! nothing moves before the delay is over.

use super::{Options, Progress, Solution, nested::Silent, release::is_worth_a_choice, solve};
use crate::experiment::{Experiment, Reading};
use crate::fit::Fit;
use crate::levenberg::{Found, search};
use crate::problem::{IdentifyError, Problem};
use crate::recording::Hold;

/// A first command so far from the first angle may be one that has just come, deg.
const FAR_DEG: f64 = 1.0;

/// Whether it may make a difference that the actuator rests until the first command arrives.
pub fn may_begin_at_rest(run: &Experiment) -> bool {
    let first_deg = run.command.first().map_or(f64::NAN, |segment| segment.q[0]);
    let angles = run.recording.angle_deg.iter();
    let angle_deg = angles.copied().find(|a| !a.is_nan()).unwrap_or(f64::NAN);
    (first_deg - angle_deg).abs() > FAR_DEG
}

fn may_be_held(run: &Experiment) -> bool {
    run.recording.hold == Hold::Auto && run.command.iter().any(|segment| !segment.is_constant)
}

/// The readings of recordings beside the usual one.
fn others(problem: &Problem) -> Vec<Reading> {
    let any = |of: fn(&Experiment) -> bool| problem.experiments.iter().any(of);
    let (held, at_rest) = (any(may_be_held), any(may_begin_at_rest));
    let all = [(true, false), (false, true), (true, true)];
    let possible = all.into_iter().filter(|(h, r)| h <= &held && r <= &at_rest);
    let reading = |(is_held, begins_at_rest)| Reading {
        is_held,
        begins_at_rest,
    };
    possible.map(reading).collect()
}

/// The problem in another reading of its recordings, if one fits better than by chance, and the solution.
pub fn decided(
    problem: &Problem,
    usual: Solution,
    options: &Options,
    progress: &dyn Progress,
    known: &[&Fit],
) -> Result<(Option<Problem>, Solution), IdentifyError> {
    let is_stopped = || progress.is_stopped();
    let searched = |reading: Reading| {
        let other = problem.read(reading);
        let (start, limits) = (&usual.found.point, &options.limits);
        let found = search(&other, &usual.unknowns, start, limits, &is_stopped)?;
        Some((reading, other, found))
    };
    let searched: Vec<_> = (others(problem).into_iter().filter_map(searched)).collect();
    let is_better = |more: f64, less: f64| is_worth_a_choice(problem, &usual.unknowns, more, less);
    let is_as_good = |found: &Found| {
        !is_better(usual.found.cost, found.cost) && !is_better(found.cost, usual.found.cost)
    };
    let mut held = searched.iter().filter(|(reading, ..)| reading.is_held);
    let is_hold_open = held.any(|(.., found)| is_as_good(found));
    let best = searched
        .into_iter()
        .min_by(|a, b| a.2.cost.total_cmp(&b.2.cost));
    let Some((reading, other, found)) =
        best.filter(|(.., found)| is_better(usual.found.cost, found.cost))
    else {
        let usual = Solution {
            is_hold_open,
            ..usual
        };
        return Ok((None, usual));
    };
    let mut solution = solve(&other, options, &Silent(progress), known)?;
    // Where needless terms were left out on purpose, that a search with all of them ends lower says nothing.
    if solution.no_better_than.is_none() && found.cost < solution.found.cost {
        solution.found = found;
    }
    if !is_better(usual.found.cost, solution.found.cost) {
        return Ok((None, usual));
    }
    solution.reading = reading;
    Ok((Some(other), solution))
}
