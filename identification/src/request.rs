//! The settings of a search by the names of parameters, as on the command line or in Python.

use std::sync::Arc;

use super::{
    assessment::Assessment,
    contradictions::ParameterOption,
    engine::{Options, Progress, fit_from},
    experiment::Experiment,
    fit::Fit,
    model::{Model, ModelParameter},
    problem::{IdentifyError, Problem, Scope},
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
        let parameters = || models.iter().flat_map(|m| m.parameters());
        let fixed = self.fix.iter().chain(&self.start).map(|(name, _)| name);
        let named = fixed
            .chain(self.bound.iter().map(|(name, ..)| name))
            .chain(self.free.iter().chain(&self.own).chain(&self.share));
        for name in named {
            if !parameters().any(|p| p.is_called(name)) {
                let mut known: Vec<&'static str> = parameters().map(|p| p.name).collect();
                known.sort_unstable();
                known.dedup();
                return Err(RequestError::UnknownParameter {
                    name: name.clone(),
                    known,
                });
            }
        }
        let table: Vec<ModelParameter> = parameters().copied().collect();
        self.check_contradictions(&table)
    }

    fn check_contradictions(&self, table: &[ModelParameter]) -> Result<(), RequestError> {
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

    fn problem(
        &self,
        model: Arc<dyn Model>,
        experiments: &[Experiment],
    ) -> Result<Problem, IdentifyError> {
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
