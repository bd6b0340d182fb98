//! Which parameters of which model are looked for in which experiments.

use std::sync::Arc;

use model_core::parameter::Parameter;

use super::experiment::Experiment;
use super::model::Model;
use super::recording::RecordingError;

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
    /// A start value or a bound is none.
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
    /// The caller stopped the search before it found anything.
    #[error("interrupted")]
    Interrupted,
}
