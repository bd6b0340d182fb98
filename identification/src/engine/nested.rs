//! Starts from where the special cases of a model fit best.

use std::sync::Arc;

use super::{Options, Progress, solve};
use crate::fit::Fit;
use crate::model::Model;
use crate::problem::{IdentifyError, Problem, Role, Spec};
use crate::unknowns::{Unknown, Unknowns};

/// The share of the cost that a step to a start has to promise.
const ROUGH_DECREASE: f64 = 1e-6;

/// Passes on the wish to stop and nothing else: steps within a step are no progress.
pub struct Silent<'a>(pub &'a dyn Progress);

impl Progress for Silent<'_> {
    fn is_stopped(&self) -> bool {
        self.0.is_stopped()
    }
}

/// A start where something simpler fits best.
pub struct Nested {
    /// The unknowns there.
    pub point: Vec<f64>,
    /// The special case that it is of, and how many of the unknowns that one does not have; `None`
    /// for a form of the model itself.
    pub case: Option<(&'static str, usize)>,
}

/// One start for each special case, and one for each fit of `known` that is of one or of the model
/// itself. What is known is not searched for again.
pub fn starts(
    problem: &Problem,
    unknowns: &Unknowns,
    options: &Options,
    progress: &dyn Progress,
    known: &[&Fit],
) -> Vec<Nested> {
    let runs = problem.experiments.len();
    let mut starts = Vec::new();
    for fit in known.iter().filter(|f| f.model == problem.model.name()) {
        let own = problem.model.as_ref();
        starts.extend(of_fit(fit, own, runs).map(|values| Nested {
            point: lifted(problem, unknowns, own, &values),
            case: None,
        }));
    }
    for case in problem.model.special_cases() {
        let of_case = |values: Vec<Vec<f64>>| Nested {
            point: lifted(problem, unknowns, case.as_ref(), &values),
            case: Some((case.name(), beyond(unknowns, case.as_ref()))),
        };
        let mut fits = known.iter().filter(|f| f.model == case.name()).peekable();
        if fits.peek().is_some() {
            let values = fits.filter_map(|fit| of_fit(fit, case.as_ref(), runs));
            starts.extend(values.map(of_case));
        } else if options.starts > 1
            && let Ok(values) = searched(problem, &case, options, progress)
        {
            // A case of which nothing is free has no optimum to begin from.
            starts.push(of_case(values));
        }
    }
    starts
}

/// How many of the unknowns a case has not; its parameters are those of the model.
fn beyond(unknowns: &Unknowns, case: &dyn Model) -> usize {
    let unknowns = unknowns.list.iter();
    let lacking = unknowns.filter(|unknown| {
        unknown.parameter < case.parameters().len() && case.is_fixed_by_default(unknown.parameter)
    });
    lacking.count()
}

/// The unknowns that answer as a case does with these values, of each run.
fn lifted(
    problem: &Problem,
    unknowns: &Unknowns,
    case: &dyn Model,
    values: &[Vec<f64>],
) -> Vec<f64> {
    let one = |unknown: &Unknown| {
        let values = &values[unknown.experiment.unwrap_or(0)];
        let value = problem.model.lifted(unknown.parameter, case, values);
        let value = value.filter(|v| !v.is_nan()).unwrap_or(unknown.start);
        // A bound of infinity is none that a search can begin at.
        value.clamp(unknown.low, unknown.high).min(f64::MAX)
    };
    unknowns.list.iter().map(one).collect()
}

/// The values of a finished fit in each run; `None` where it has not all parameters of its model.
fn of_fit(fit: &Fit, model: &dyn Model, runs: usize) -> Option<Vec<Vec<f64>>> {
    let value = |name: &str, run: usize| {
        let is_of_it =
            |e: &&crate::fit::Estimate| e.name == name && e.experiment.is_none_or(|own| own == run);
        fit.estimates.iter().find(is_of_it).map(|e| e.value)
    };
    let of_run = |run| {
        let parameters = model.parameters().iter();
        parameters.map(|p| value(p.name, run)).collect()
    };
    (0..runs).map(of_run).collect()
}

/// The values of a special case in each run where it fits best.
fn searched(
    problem: &Problem,
    case: &Arc<dyn Model>,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Vec<Vec<f64>>, IdentifyError> {
    // As the case would be searched alone, so that this model fits no worse than that one; a rough cost, which takes
    // long, to no more digits than a start needs.
    let mut options = *options;
    if case.is_rough() {
        options.limits.decrease = ROUGH_DECREASE.max(options.limits.decrease);
    }
    let simple = simplified(problem, case)?;
    let solution = solve(&simple, &options, &Silent(progress), &[])?;
    let runs = solution.unknowns.runs.iter();
    Ok(runs.map(|run| run.values(&solution.found.point)).collect())
}

/// The same problem of a special case: what both have is asked of both alike.
fn simplified(problem: &Problem, case: &Arc<dyn Model>) -> Result<Problem, IdentifyError> {
    let mut simple = Problem::try_new(case.clone(), problem.experiments.clone())?;
    for (index, spec) in simple.specs.iter_mut().enumerate() {
        let is_it = |other: &&(usize, &Spec)| other.1.parameter.name == spec.parameter.name;
        let specs: Vec<(usize, &Spec)> = problem.specs.iter().enumerate().collect();
        let Some((place, asked)) = specs.iter().find(is_it) else {
            continue;
        };
        *spec = Spec {
            parameter: spec.parameter,
            ..**asked
        };
        if case.is_fixed_by_default(index) && !problem.model.is_fixed_by_default(*place) {
            spec.role = Role::Fixed;
        }
    }
    Ok(simple)
}
