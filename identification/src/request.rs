//! The settings of a search by the names of parameters, as on the command line or in Python.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
    sync::Arc,
};

use super::{
    assessment::Assessment,
    contradictions::ParameterOption,
    engine::{Options, Progress, fit_from},
    experiment::Experiment,
    fit::Fit,
    model::{Model, ModelParameter},
    problem::{IdentifyError, Problem, Scope},
    recording::Recording,
};

/// The settings of the parameters. Each of several models uses those of the parameters that it has.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Request {
    /// Fixed at these values.
    pub fix: Vec<(String, f64)>,
    /// Freed, though fixed by default.
    pub free: Vec<String>,
    /// Bounded: name, low, high.
    pub bound: Vec<(String, f64, f64)>,
    /// Starting values.
    pub start: Vec<(String, f64)>,
    /// With one value for each recording.
    pub own: Vec<String>,
    /// With one value for all recordings.
    pub share: Vec<String>,
    /// Options of the search.
    pub options: Options,
}

/// Why a [`Request`] is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RequestError {
    /// None of the models has a parameter of this name.
    #[error("unknown parameter `{name}`; expected {}", known.join(", "))]
    UnknownParameter {
        /// The unknown name.
        name: String,
        /// The parameters of all models, sorted by name.
        known: Vec<&'static str>,
    },
    /// Two options contradict each other.
    #[error("{0}")]
    Conflict(String),
}

/// Known constants of recordings by the names of the parameters, for which symbols may be given.
///
/// # Errors
/// [`RequestError::UnknownParameter`] for a name that none of the models has;
/// [`RequestError::Conflict`] for a value that is not finite.
pub fn known_constants(
    models: &[Arc<dyn Model>],
    given: &[(String, f64)],
) -> Result<BTreeMap<String, f64>, RequestError> {
    let mut constants = BTreeMap::new();
    for (name, value) in given {
        if !value.is_finite() {
            let problem = format!("the known {name} is {value}, expected a finite number");
            return Err(RequestError::Conflict(problem));
        }
        let called = parameters(models).filter(|p| p.is_called(name));
        let names: Vec<&str> = called.map(|p| p.name).collect();
        if names.is_empty() {
            return Err(unknown(name, models));
        }
        constants.extend(names.into_iter().map(|name| (name.to_owned(), *value)));
    }
    Ok(constants)
}

/// Refuses a file that is named twice: fitted, its samples would count twice, and as a held-out one
/// it would prove nothing.
///
/// # Errors
/// [`RequestError::Conflict`].
pub fn check_files<'a>(
    fitted: impl IntoIterator<Item = &'a Path>,
    held_out: impl IntoIterator<Item = &'a Path>,
) -> Result<(), RequestError> {
    let place = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.into());
    let mut seen = BTreeSet::new();
    if let Some(path) = fitted.into_iter().find(|path| !seen.insert(place(path))) {
        let problem = format!("{} is fitted twice, expected it once", path.display());
        return Err(RequestError::Conflict(problem));
    }
    match held_out.into_iter().find(|path| !seen.insert(place(path))) {
        None => Ok(()),
        Some(path) => Err(RequestError::Conflict(format!(
            "{} validates and is there already, expected another file",
            path.display()
        ))),
    }
}

/// Whether none of the models needs the command of a recording: they are driven by its duty.
pub fn may_lack_command(models: &[Arc<dyn Model>]) -> bool {
    let needs_duty = |model: &Arc<dyn Model>| model.accepts(&Recording::default()).is_err();
    models.iter().all(needs_duty)
}

fn parameters(models: &[Arc<dyn Model>]) -> impl Iterator<Item = &ModelParameter> {
    models.iter().flat_map(|model| model.parameters())
}

/// The error for a name that none of the models has.
fn unknown(name: &str, models: &[Arc<dyn Model>]) -> RequestError {
    let mut known: Vec<&'static str> = parameters(models).map(|p| p.name).collect();
    known.sort_unstable();
    known.dedup();
    RequestError::UnknownParameter {
        name: name.to_owned(),
        known,
    }
}

impl Request {
    /// Fits one model, and predicts the held-out recordings. Simpler models that were fitted
    /// `before` to the same recordings provide starting values.
    ///
    /// # Errors
    /// Those of [`Problem`] and of [`fit`](fn@super::fit).
    pub fn assess(
        &self,
        model: Arc<dyn Model>,
        (fitted, held_out): (&[Experiment], &[Experiment]),
        before: &[Assessment],
        progress: &dyn Progress,
    ) -> Result<Assessment, IdentifyError> {
        let problem = self.problem(model, fitted)?;
        let known: Vec<&Fit> = before.iter().map(|assessment| &assessment.fit).collect();
        let found = fit_from(&problem, &self.options, progress, &known)?;
        Assessment::of(found.model, &problem, found, held_out)
    }

    /// Checks that each named parameter belongs to at least one of the models, and that no two
    /// options contradict each other.
    ///
    /// # Errors
    /// [`RequestError::UnknownParameter`], [`RequestError::Conflict`].
    pub fn check(&self, models: &[Arc<dyn Model>]) -> Result<(), RequestError> {
        let fixed = self.fix.iter().chain(&self.start).map(|(name, _)| name);
        let named = fixed
            .chain(self.bound.iter().map(|(name, ..)| name))
            .chain(self.free.iter().chain(&self.own).chain(&self.share));
        for name in named {
            if !parameters(models).any(|p| p.is_called(name)) {
                return Err(unknown(name, models));
            }
        }
        let table: Vec<ModelParameter> = parameters(models).copied().collect();
        self.check_contradictions(&table)
            .map_err(RequestError::Conflict)
    }

    fn check_contradictions(&self, table: &[ModelParameter]) -> Result<(), String> {
        let fix = ParameterOption::new("fix", self.fix.iter().map(|(name, _)| name));
        let free = ParameterOption::new("free", &self.free);
        let bound = ParameterOption::new("bound", self.bound.iter().map(|(name, ..)| name));
        let start = ParameterOption::new("start", self.start.iter().map(|(name, _)| name));
        let own = ParameterOption::new("own", &self.own);
        for valued in [&fix, &bound, &start] {
            valued.once(table)?;
        }
        for of_a_search in [&free, &bound, &start] {
            fix.without(of_a_search, table)?;
        }
        own.without(&ParameterOption::new("share", &self.share), table)
    }

    /// Refuses a recording without what the model cannot assume.
    fn check_measured(
        &self,
        model: &dyn Model,
        experiments: &[Experiment],
    ) -> Result<(), IdentifyError> {
        let is_set = |parameter: &ModelParameter| {
            let valued = self.fix.iter().chain(&self.start).map(|(name, _)| name);
            valued
                .chain(&self.free)
                .any(|name| parameter.is_called(name))
        };
        for Experiment { recording, .. } in experiments {
            let mut parameters = model.parameters().iter();
            let unmeasured = model.unmeasured(recording);
            let unmeasured = parameters.find(|p| Some(p.name) == unmeasured && !is_set(p));
            if let Some(parameter) = unmeasured {
                return Err(IdentifyError::Unmeasured {
                    recording: recording.name.clone(),
                    parameter: parameter.name,
                });
            }
        }
        Ok(())
    }

    fn problem(
        &self,
        model: Arc<dyn Model>,
        experiments: &[Experiment],
    ) -> Result<Problem, IdentifyError> {
        self.check_measured(&*model, experiments)?;
        let parameters = model.parameters().to_vec();
        let has = |name: &str| parameters.iter().any(|p| p.is_called(name));
        let mut problem = Problem::try_new(model, experiments.to_vec())?;
        for (name, low, high) in self.bound.iter().filter(|(name, ..)| has(name)) {
            problem.bound(name, *low, *high)?;
        }
        for name in self.free.iter().filter(|name| has(name)) {
            problem.free(name)?;
        }
        for (name, value) in self.start.iter().filter(|(name, _)| has(name)) {
            problem.start(name, *value)?;
        }
        for (name, value) in self.fix.iter().filter(|(name, _)| has(name)) {
            problem.fix(name, *value)?;
        }
        for (names, scope) in [(&self.own, Scope::Own), (&self.share, Scope::Shared)] {
            for name in names.iter().filter(|name| has(name)) {
                problem.scope(name, scope)?;
            }
        }
        Ok(problem)
    }
}
