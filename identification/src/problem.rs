//! What is fitted: a model, experiments, and the role of each parameter.

use std::sync::Arc;

use model_core::parameter::{Parameter, Shown};

use super::experiment::{Assumptions, Experiment};
use super::loss::Loss;
use super::model::Model;
use super::recording::RecordingError;
use super::start::{DataSummary, greatest_angle_deg};

/// Starting value of a limit, as a share of the largest observed value.
const INSIDE: f64 = 0.98;

/// Whether a parameter is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// It is estimated.
    Free,
    /// It keeps its starting value, or the one known for the run.
    Fixed,
}

/// Whether the experiments share one value of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// All experiments share it.
    Shared,
    /// Each experiment has its own.
    Own,
}

/// The settings of a parameter in a problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spec {
    /// Its declaration.
    pub parameter: Parameter,
    /// Whether it is estimated.
    pub role: Role,
    /// Whether the experiments share it.
    pub scope: Scope,
    /// Its starting value; its value where it is fixed.
    pub start: f64,
    /// Lower bound of the search.
    pub low: f64,
    /// Upper bound of the search.
    pub high: f64,
}

/// A model and the experiments to fit it to.
#[derive(Clone)]
pub struct Problem {
    /// The model.
    pub model: Arc<dyn Model>,
    /// The experiments.
    pub experiments: Vec<Experiment>,
    /// One for each parameter of the model.
    pub specs: Vec<Spec>,
    /// The starting values that are estimated from the data, in the order of the parameters.
    estimates: Vec<f64>,
}

impl Problem {
    /// A model and experiments with the default settings: the experiments share the parameters of
    /// the actuator, each has its own initial state, and the starting values are estimated from the
    /// data.
    ///
    /// # Errors
    /// [`IdentifyError::NoRecording`], or [`IdentifyError::Recording`] for one without a column
    /// that the model needs.
    pub fn try_new(
        model: Arc<dyn Model>,
        experiments: Vec<Experiment>,
    ) -> Result<Self, IdentifyError> {
        if experiments.is_empty() {
            return Err(IdentifyError::NoRecording);
        }
        for experiment in &experiments {
            let recording = &experiment.recording;
            model
                .accepts(recording)
                .map_err(|error| IdentifyError::Recording {
                    name: recording.name.clone(),
                    error,
                })?;
        }
        let estimates = model.starting_values(&experiments);
        let specs = model.parameters().iter().zip(&estimates);
        let specs = specs.map(|(p, start)| Spec {
            parameter: p.parameter,
            role: if p.is_fixed { Role::Fixed } else { Role::Free },
            scope: if p.is_initial_state {
                Scope::Own
            } else {
                Scope::Shared
            },
            start: start.clamp(p.bounds.0, p.bounds.1),
            low: p.bounds.0,
            high: p.bounds.1,
        });
        Ok(Self {
            specs: specs.collect(),
            model,
            experiments,
            estimates,
        })
    }

    /// The starting values that were estimated from the data, in the order of the parameters.
    pub fn estimates(&self) -> &[f64] {
        &self.estimates
    }

    fn spec(&mut self, name: &str) -> Result<&mut Spec, IdentifyError> {
        let names = self.specs.iter().map(|s| s.parameter.name);
        let unknown = IdentifyError::UnknownParameter {
            model: self.model.name(),
            name: name.into(),
            expected: names.collect::<Vec<_>>().join(", "),
        };
        let mut specs = self.specs.iter_mut();
        specs.find(|s| s.parameter.is_called(name)).ok_or(unknown)
    }

    /// Fixes a parameter at a value.
    ///
    /// # Errors
    /// [`IdentifyError::UnknownParameter`]; [`IdentifyError::Value`] for a value out of range.
    pub fn fix(&mut self, name: &str, value: f64) -> Result<(), IdentifyError> {
        let spec = self.spec(name)?;
        let Parameter { min, max, .. } = spec.parameter;
        // A fixed limit may be infinite, which the search could not find.
        let is_no_limit = value == f64::INFINITY && spec.parameter.default == f64::INFINITY;
        if !(value >= min && value <= max || is_no_limit) {
            return Err(IdentifyError::Value {
                name: spec.parameter.name,
                value,
                min,
                max,
            });
        }
        spec.role = Role::Fixed;
        spec.start = value;
        Ok(())
    }

    /// Frees a parameter.
    ///
    /// # Errors
    /// [`IdentifyError::UnknownParameter`].
    pub fn free(&mut self, name: &str) -> Result<(), IdentifyError> {
        let spec = *self.spec(name)?;
        let seen = match spec.parameter.unit {
            _ if spec.start.is_finite() => None,
            "deg" => Some(greatest_angle_deg(&self.experiments)),
            "deg/s" => Some(DataSummary::of(&self.experiments).rate_up_deg_s),
            _ => None,
        };
        // An infinite limit has no sensitivity: the search begins where it is just reached.
        let start = seen.map_or(spec.start, |seen| {
            (INSIDE * seen).clamp(spec.low, spec.high)
        });
        *self.spec(name)? = Spec {
            role: Role::Free,
            start,
            ..spec
        };
        Ok(())
    }

    /// Sets the starting value of a parameter.
    ///
    /// # Errors
    /// [`IdentifyError::UnknownParameter`]; [`IdentifyError::Start`] for a value beyond its bounds.
    pub fn start(&mut self, name: &str, value: f64) -> Result<(), IdentifyError> {
        let spec = self.spec(name)?;
        if !(value >= spec.low && value <= spec.high) {
            return Err(spec.wrong_start(value));
        }
        spec.start = value;
        Ok(())
    }

    /// Bounds a parameter; the bounds may be infinite where its range is.
    ///
    /// # Errors
    /// [`IdentifyError::UnknownParameter`]; [`IdentifyError::Order`] and [`IdentifyError::Range`]
    /// for bounds that contain no value.
    pub fn bound(&mut self, name: &str, low: f64, high: f64) -> Result<(), IdentifyError> {
        let spec = self.spec(name)?;
        let Parameter { name, min, max, .. } = spec.parameter;
        if low.is_nan() || high.is_nan() || low >= high {
            return Err(IdentifyError::Order { name, low, high });
        }
        let within = (low.max(min), high.min(max));
        if within.0 >= within.1 {
            return Err(IdentifyError::Range {
                name,
                low,
                high,
                min,
                max,
            });
        }
        (spec.low, spec.high) = within;
        spec.start = spec.start.clamp(spec.low, spec.high);
        Ok(())
    }

    /// Sets whether the experiments share a parameter.
    ///
    /// # Errors
    /// [`IdentifyError::UnknownParameter`].
    pub fn scope(&mut self, name: &str, scope: Scope) -> Result<(), IdentifyError> {
        self.spec(name)?.scope = scope;
        Ok(())
    }

    /// The same problem with other experiments and unchanged starting values.
    pub fn with_experiments(&self, experiments: Vec<Experiment>) -> Self {
        Self {
            experiments,
            ..self.clone()
        }
    }

    /// The same problem with another loss.
    pub fn with_loss(&self, loss: Loss) -> Self {
        let runs = self.experiments.iter().cloned();
        self.with_experiments(runs.map(|run| Experiment { loss, ..run }).collect())
    }

    /// The same problem under other assumptions about its recordings.
    pub fn under(&self, assumptions: Assumptions) -> Self {
        self.with_experiments(
            self.experiments
                .iter()
                .map(|run| run.under(assumptions))
                .collect(),
        )
    }
}

impl Spec {
    fn wrong_start(&self, start: f64) -> IdentifyError {
        IdentifyError::Start {
            name: self.parameter.name,
            start,
            low: self.low,
            high: self.high,
        }
    }

    /// Whether the search uses its logarithm: a positive parameter, of which ratios matter.
    pub fn is_log_scaled(&self) -> bool {
        self.parameter.min > 0.0
    }

    /// Whether ratios of it matter, rather than differences.
    pub fn has_scale(&self) -> bool {
        self.is_log_scaled() || self.parameter.unit == "s" || self.parameter.unit == "1"
    }
}

/// Why a model could not be fitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum IdentifyError {
    /// A recording cannot be used.
    #[error("recording {name}: {error}")]
    Recording {
        /// Its name.
        name: String,
        /// The reason.
        error: RecordingError,
    },
    /// A recording has no value of a parameter that must be measured.
    #[error(
        "recording {recording}: {parameter} is not known, expected its column, a known constant \
         (--known), or a fixed value (--fix)"
    )]
    Unmeasured {
        /// Name of the recording.
        recording: String,
        /// The parameter.
        parameter: &'static str,
    },
    /// There is no recording to fit to.
    #[error("no recording, expected at least one")]
    NoRecording,
    /// The model has no such parameter.
    #[error("model {model} has no parameter {name}, expected one of {expected}")]
    UnknownParameter {
        /// The model.
        model: &'static str,
        /// The parameter.
        name: String,
        /// The model's parameters.
        expected: String,
    },
    /// A fixed value is out of range.
    #[error("{name} is held at {}, expected {min} to {max}", Shown(*value))]
    Value {
        /// The parameter.
        name: &'static str,
        /// The value.
        value: f64,
        /// Lower end of its range.
        min: f64,
        /// Upper end of its range.
        max: f64,
    },
    /// The lower bound is not below the upper one.
    #[error(
        "{name} is bound to {}:{}, expected the lower bound before a greater one",
        Shown(*low),
        Shown(*high)
    )]
    Order {
        /// The parameter.
        name: &'static str,
        /// The first bound.
        low: f64,
        /// The second one.
        high: f64,
    },
    /// The bounds are out of range.
    #[error(
        "{name} is bound to {}:{}, expected bounds within its range, {min} to {max}",
        Shown(*low),
        Shown(*high)
    )]
    Range {
        /// The parameter.
        name: &'static str,
        /// The lower bound.
        low: f64,
        /// The upper bound.
        high: f64,
        /// Lower end of its range.
        min: f64,
        /// Upper end of its range.
        max: f64,
    },
    /// A starting value is not within its bounds.
    #[error(
        "{name} starts at {} within {low} to {high}, expected a number within its bounds",
        Shown(*start)
    )]
    Start {
        /// The parameter.
        name: &'static str,
        /// Its starting value.
        start: f64,
        /// Its lower bound.
        low: f64,
        /// Its upper bound.
        high: f64,
    },
    /// All parameters are fixed.
    #[error("no free parameter, expected at least one")]
    NothingFree,
    /// There are too few samples for the unknowns.
    #[error(
        "{samples} samples with an angle for {parameters} free parameters, expected at least \
         {expected}"
    )]
    TooFewSamples {
        /// Unknowns.
        parameters: usize,
        /// Data.
        samples: usize,
        /// Required data.
        expected: usize,
    },
    /// The model diverges from all starting values.
    #[error("the model answers with no numbers from any start value")]
    NotFinite,
}
