//! Starting values from the optima of nested models.

use std::sync::Arc;

use super::{Options, Progress, solve};
use crate::fit::{Estimate, Fit};
use crate::model::{Model, NestedOptimum};
use crate::problem::{IdentifyError, Problem, Role, Spec};
use crate::unknowns::{Unknown, Unknowns};

/// Decrease of the cost, as a share, to which a model with many minima is searched for starting
/// values.
const ROUGH_DECREASE: f64 = 1e-6;

/// Forwards the request to stop and nothing else: inner searches report no progress.
pub struct CancelOnly<'a>(pub &'a dyn Progress);

impl Progress for CancelOnly<'_> {
    fn is_stopped(&self) -> bool {
        self.0.is_stopped()
    }
}

/// Starting values from the optimum of a simpler problem.
pub struct NestedStart {
    /// The unknowns.
    pub point: Vec<f64>,
    /// The nested model, and how many of the unknowns it lacks; `None` for the model itself with
    /// some of its parameters fixed.
    pub model: Option<(&'static str, usize)>,
}

/// One start for each nested model, and one for each fit of `known` that is of a nested model or of
/// the model itself. Known fits are not searched for again.
pub fn starts(
    problem: &Problem,
    unknowns: &Unknowns,
    options: &Options,
    progress: &dyn Progress,
    known: &[&Fit],
) -> Vec<NestedStart> {
    let runs = problem.experiments.len();
    let mut starts = Vec::new();
    for fit in known.iter().filter(|f| f.model == problem.model.name()) {
        let own = problem.model.as_ref();
        starts.extend(values_of(fit, own, runs).map(|values| NestedStart {
            point: extended(problem, unknowns, own, &values),
            model: None,
        }));
    }
    for nested in problem.model.nested_models() {
        let start = |values: Vec<Vec<f64>>| NestedStart {
            point: extended(problem, unknowns, nested.as_ref(), &values),
            model: Some((nested.name(), lacking(problem, unknowns, nested.as_ref()))),
        };
        let mut fits = known.iter().filter(|f| f.model == nested.name()).peekable();
        if fits.peek().is_some() {
            let values = fits.filter_map(|fit| values_of(fit, nested.as_ref(), runs));
            starts.extend(values.map(start));
        } else if options.starts > 1
            && let Ok(values) = searched(problem, &nested, options, progress)
        {
            // A nested model without a free parameter has no optimum to begin from.
            starts.push(start(values));
        }
    }
    starts
}

/// How many of the unknowns a nested model fixes.
fn lacking(problem: &Problem, unknowns: &Unknowns, nested: &dyn Model) -> usize {
    let parameters = problem.model.parameters();
    let names = unknowns.list.iter().map(|u| parameters[u.parameter].name);
    names
        .filter(|name| nested.is_fixed_by_default(name))
        .count()
}

/// The unknowns with which the model reproduces a nested one with these values of each run.
fn extended(
    problem: &Problem,
    unknowns: &Unknowns,
    nested: &dyn Model,
    values: &[Vec<f64>],
) -> Vec<f64> {
    let one = |unknown: &Unknown| {
        let nested = NestedOptimum {
            model: nested,
            values: &values[unknown.experiment.unwrap_or(0)],
        };
        let name = problem.specs[unknown.parameter].parameter.name;
        let value = problem.model.value_from_nested(name, &nested);
        let value = value.filter(|v| !v.is_nan()).unwrap_or(unknown.start);
        // A search cannot begin at an infinite bound.
        value.clamp(unknown.low, unknown.high).min(f64::MAX)
    };
    unknowns.list.iter().map(one).collect()
}

/// The values of a finished fit in each run; `None` where it lacks a parameter of its model.
fn values_of(fit: &Fit, model: &dyn Model, runs: usize) -> Option<Vec<Vec<f64>>> {
    let value = |name: &str, run: usize| {
        let applies = |e: &&Estimate| e.name == name && e.experiment.is_none_or(|own| own == run);
        fit.estimates.iter().find(applies).map(|e| e.value)
    };
    let of_run = |run| {
        let parameters = model.parameters().iter();
        parameters.map(|p| value(p.name, run)).collect()
    };
    (0..runs).map(of_run).collect()
}

/// The values of a nested model in each run at its optimum.
fn searched(
    problem: &Problem,
    nested: &Arc<dyn Model>,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Vec<Vec<f64>>, IdentifyError> {
    // Searched with the same options as alone, so that this model does not fit worse; a model with
    // many minima, which takes long, only to the precision of a starting value.
    let mut options = *options;
    if nested.has_many_minima() {
        options.limits.decrease = ROUGH_DECREASE.max(options.limits.decrease);
    }
    let simple = simplified(problem, nested)?;
    let solution = solve(&simple, &options, &CancelOnly(progress), &[])?;
    let runs = solution.unknowns.runs.iter();
    Ok(runs.map(|run| run.values(&solution.found.point)).collect())
}

/// The problem of a nested model, with the same settings for the parameters that both have.
fn simplified(problem: &Problem, nested: &Arc<dyn Model>) -> Result<Problem, IdentifyError> {
    let mut simple = Problem::try_new(nested.clone(), problem.experiments.clone())?;
    for spec in &mut simple.specs {
        let name = spec.parameter.name;
        let Some(index) = problem.model.parameter_index(name) else {
            continue;
        };
        *spec = Spec {
            parameter: spec.parameter,
            ..problem.specs[index]
        };
        if nested.is_fixed_by_default(name) && !problem.model.is_fixed_by_default(name) {
            spec.role = Role::Fixed;
        }
    }
    Ok(simple)
}
