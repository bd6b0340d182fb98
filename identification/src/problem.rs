//! Which parameters of which model are looked for in which experiments.

use std::sync::Arc;

use model_core::parameter::Parameter;

use super::experiment::{Experiment, Reading};
use super::model::Model;
use super::recording::RecordingError;
use super::start::{DataSummary, greatest_angle_deg};

/// The share of what was seen at which the search for a limit begins.
const INSIDE: f64 = 0.98;

/// Whether a parameter is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// It is.
    Free,
    /// It has its start value, or the one that is known of the run.
    Fixed,
}

/// Whether experiments have one value of a parameter in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// All have the same.
    Shared,
    /// Each has its own.
    Own,
}

/// What is asked of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spec {
    /// What is known of it.
    pub parameter: Parameter,
    /// Whether it is looked for.
    pub role: Role,
    /// Whether the experiments have it in common.
    pub scope: Scope,
    /// Where the search begins; the value where it is fixed.
    pub start: f64,
    /// The least value that it may take.
    pub low: f64,
    /// The greatest value that it may take.
    pub high: f64,
}

/// What is to be fitted to what.
#[derive(Clone)]
pub struct Problem {
    /// The model.
    pub model: Arc<dyn Model>,
    /// The experiments.
    pub experiments: Vec<Experiment>,
    /// One for each parameter of the model.
    pub specs: Vec<Spec>,
}

impl Problem {
    /// A model and recordings with everything as it usually is: what belongs to the actuator is
    /// shared, what belongs to a run is its own, and the search begins where a first look says.
    ///
    /// # Errors
    /// [`IdentifyError::NoRecording`], or [`IdentifyError::Recording`] where one lacks what the
    /// model needs.
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
        let start = model.starting_values(&experiments);
        let specs = model.parameters().iter().zip(start).map(|(p, start)| Spec {
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
        })
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

    /// Holds a parameter at a value.
    ///
    /// # Errors
    /// [`IdentifyError::UnknownParameter`]; [`IdentifyError::Value`] for one that it cannot take.
    pub fn fix(&mut self, name: &str, value: f64) -> Result<(), IdentifyError> {
        let spec = self.spec(name)?;
        let Parameter { min, max, .. } = spec.parameter;
        // What is not looked for may be what the search could not find, such as no limit.
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

    /// Has a parameter looked for.
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
        // A limit that is none has no slope to follow: the search begins where it would just be met.
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

    /// Begins the search for a parameter at a value.
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

    /// Keeps a parameter within bounds, which may be infinite where its range is.
    ///
    /// # Errors
    /// [`IdentifyError::UnknownParameter`]; [`IdentifyError::Order`] and [`IdentifyError::Range`] for
    /// bounds that leave nothing.
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

    /// Has all experiments have one value of a parameter, or each its own.
    ///
    /// # Errors
    /// [`IdentifyError::UnknownParameter`].
    pub fn scope(&mut self, name: &str, scope: Scope) -> Result<(), IdentifyError> {
        self.spec(name)?.scope = scope;
        Ok(())
    }

    /// The problem of the same model with other experiments, each start value as it is.
    pub fn with_experiments(&self, experiments: Vec<Experiment>) -> Self {
        Self {
            experiments,
            ..self.clone()
        }
    }

    /// The same with its recordings in another reading.
    pub fn read(&self, reading: Reading) -> Self {
        self.with_experiments(
            self.experiments
                .iter()
                .map(|run| run.read(reading))
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

    /// Whether it is a size, whose logarithm is the better unknown: factors count, not differences.
    pub fn is_size(&self) -> bool {
        self.parameter.min > 0.0
    }
}

/// Why nothing could be identified.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum IdentifyError {
    /// A recording cannot be used.
    #[error("recording {name}: {error}")]
    Recording {
        /// Its name.
        name: String,
        /// What is wrong with it.
        error: RecordingError,
    },
    /// There is nothing to fit to.
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
    /// A value at which a parameter is held is none of it.
    #[error("{name} is held at {value}, expected {min} to {max}")]
    Value {
        /// The parameter.
        name: &'static str,
        /// The value.
        value: f64,
        /// The least that it takes.
        min: f64,
        /// The greatest that it takes.
        max: f64,
    },
    /// Bounds that leave nothing between them.
    #[error("{name} is bound to {low}:{high}, expected the lower bound before a greater one")]
    Order {
        /// The parameter.
        name: &'static str,
        /// The first bound.
        low: f64,
        /// The second one.
        high: f64,
    },
    /// Bounds beyond what the parameter can be.
    #[error("{name} is bound to {low}:{high}, expected bounds within its range, {min} to {max}")]
    Range {
        /// The parameter.
        name: &'static str,
        /// The lower bound.
        low: f64,
        /// The upper bound.
        high: f64,
        /// The least that it takes.
        min: f64,
        /// The greatest that it takes.
        max: f64,
    },
    /// A start value is none.
    #[error("{name} starts at {start} within {low} to {high}, expected a number within its bounds")]
    Start {
        /// The parameter.
        name: &'static str,
        /// Its start value.
        start: f64,
        /// Its lower bound.
        low: f64,
        /// Its upper bound.
        high: f64,
    },
    /// Everything is fixed.
    #[error("no free parameter, expected at least one")]
    NothingFree,
    /// More unknowns than data.
    #[error("{parameters} free parameters and {samples} samples, expected more samples")]
    TooFewSamples {
        /// Unknowns.
        parameters: usize,
        /// Data.
        samples: usize,
    },
    /// No start value gives a finite answer.
    #[error("the model answers with no numbers from any start value")]
    NotFinite,
}
