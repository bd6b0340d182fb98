//! Assumptions about the command that a recording leaves open, selected by the likelihood ratio.
//!
//! A command that changes from sample to sample may be a smooth curve or a zero-order hold: the two
//! differ by half a sample of delay. A first command that differs from the first angle may have
//! been applied long before, or arrive at the first sample at an actuator at rest, as in a
//! recording that is triggered by its step: then nothing moves before the delay has passed.

use super::{
    Options, Progress, Solution, likelihood_ratio::is_significant, nested::CancelOnly, solve,
};
use crate::experiment::{Assumptions, Experiment};
use crate::fit::Fit;
use crate::levenberg::{Found, search};
use crate::problem::{IdentifyError, Problem};
use crate::recording::Hold;

/// Distance of the first command from the first angle from which it may have just arrived, deg.
const FAR_DEG: f64 = 1.0;

/// Whether the actuator may be at rest until the first command arrives.
pub fn may_begin_at_rest(run: &Experiment) -> bool {
    let first_deg = run.command.first().map_or(f64::NAN, |segment| segment.q[0]);
    let angles = run.recording.angle_deg.iter();
    let angle_deg = angles.copied().find(|a| !a.is_nan()).unwrap_or(f64::NAN);
    (first_deg - angle_deg).abs() > FAR_DEG
}

fn may_be_held(run: &Experiment) -> bool {
    run.recording.hold == Hold::Auto && run.command.iter().any(|segment| !segment.is_constant)
}

/// The possible assumptions other than the default.
fn others(problem: &Problem) -> Vec<Assumptions> {
    let any = |of: fn(&Experiment) -> bool| problem.experiments.iter().any(of);
    let (held, at_rest) = (any(may_be_held), any(may_begin_at_rest));
    let all = [(true, false), (false, true), (true, true)];
    let possible = all.into_iter().filter(|(h, r)| h <= &held && r <= &at_rest);
    let assumptions = |(is_held, begins_at_rest)| Assumptions {
        is_held,
        begins_at_rest,
    };
    possible.map(assumptions).collect()
}

/// The problem under other assumptions, if these fit significantly better, and the solution.
pub fn decided(
    problem: &Problem,
    usual: Solution,
    options: &Options,
    progress: &dyn Progress,
    known: &[&Fit],
) -> Result<(Option<Problem>, Solution), IdentifyError> {
    let is_stopped = || progress.is_stopped();
    let searched = |assumptions: Assumptions| {
        let other = problem.under(assumptions);
        let (start, limits) = (&usual.found.point, &options.limits);
        let found = search(&other, &usual.unknowns, start, limits, &is_stopped)?;
        Some((assumptions, other, found))
    };
    let searched: Vec<_> = (others(problem).into_iter().filter_map(searched)).collect();
    let is_better = |more: f64, less: f64| is_significant(problem, &usual.unknowns, more, less);
    let is_as_good = |found: &Found| {
        !is_better(usual.found.cost, found.cost) && !is_better(found.cost, usual.found.cost)
    };
    let held = searched
        .iter()
        .filter(|(assumptions, _, found)| assumptions.is_held && is_as_good(found));
    let held = held.min_by(|a, b| a.2.cost.total_cmp(&b.2.cost));
    let hold_differences = held.map_or(Vec::new(), |(.., found)| {
        let pairs = found.point.iter().zip(&usual.found.point);
        pairs.map(|(held, smooth)| held - smooth).collect()
    });
    let best = searched
        .into_iter()
        .min_by(|a, b| a.2.cost.total_cmp(&b.2.cost));
    let Some((assumptions, other, found)) =
        best.filter(|(.., found)| is_better(usual.found.cost, found.cost))
    else {
        let usual = Solution {
            hold_differences,
            ..usual
        };
        return Ok((None, usual));
    };
    let mut solution = solve(&other, options, &CancelOnly(progress), known)?;
    // A solution that was reduced to a nested model has a higher cost on purpose.
    if solution.no_better_than.is_none() && found.cost < solution.found.cost {
        solution.found = found;
    }
    if !is_better(usual.found.cost, solution.found.cost) {
        return Ok((None, usual));
    }
    solution.assumptions = assumptions;
    Ok((Some(other), solution))
}
