//! Starts from where the special cases of a model fit best.

use super::{Options, Progress, solve};
use crate::identify::levenberg::Limits;
use crate::identify::problem::{IdentifyError, Problem, Role};
use crate::identify::unknowns::Unknowns;

/// The share of the cost that a step to a start has to promise.
const ROUGH_DECREASE: f64 = 1e-6;

/// Passes on the wish to stop and nothing else: steps within a step are no progress.
struct Silent<'a>(&'a dyn Progress);

impl Progress for Silent<'_> {
    fn is_stopped(&self) -> bool {
        self.0.is_stopped()
    }
}

/// One start for each special case.
pub fn starts(
    problem: &Problem,
    unknowns: &Unknowns,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Vec<Vec<f64>>, IdentifyError> {
    // As many starts as the case would have alone, so that this model fits no worse than that one;
    // but to no more digits than a start needs.
    let limits = Limits {
        decrease: ROUGH_DECREASE.max(options.limits.decrease),
        ..options.limits
    };
    let options = Options { limits, ..*options };
    let mut starts = Vec::new();
    for case in problem.model.special_cases() {
        let mut simple = problem.clone();
        for (index, spec) in simple.specs.iter_mut().enumerate() {
            if case.is_fixed_by_default(index) && !problem.model.is_fixed_by_default(index) {
                spec.role = Role::Fixed;
            }
        }
        simple.model = case;
        let (of_case, found, _) = solve(&simple, &options, &Silent(progress))?;
        let values = of_case.runs[0].values(&found.point);
        let start = unknowns.list.iter().map(|unknown| {
            let is_same = |u: &crate::identify::unknowns::Unknown| {
                u.parameter == unknown.parameter && u.experiment == unknown.experiment
            };
            let value = match of_case.list.iter().position(is_same) {
                Some(known) => found.point[known],
                None => problem.model.neutral(unknown.parameter, &values),
            };
            value.clamp(unknown.low, unknown.high)
        });
        starts.push(start.collect());
    }
    Ok(starts)
}
