//! From recordings to the parameters of a model: output-error identification in the time domain.
//!
//! The model is simulated on the recorded command alone and its angle is compared with the recorded
//! one; the parameters are those with the least sum of squared differences (Ljung, System
//! Identification, 2nd ed., section 7.2; Maine and Iliff, NASA RP-1138: output error).
//!
//! [`Recording`] is what was measured, [`Experiment`] the same made ready for simulation,
//! [`Model`] what is fitted, [`Problem`] which parameters are free, [`Fit`] the outcome.

pub mod assessment;
pub mod command;
pub mod compare;
pub mod contradictions;
mod covariance;
pub mod data;
pub mod design;
pub mod document;
pub mod engine;
pub mod experiment;
pub mod fit;
pub mod frequency;
pub mod hybrid;
pub mod levenberg;
pub mod model;
pub mod models;
pub mod normal;
pub mod parameter_file;
pub mod problem;
pub mod recording;
pub mod request;
pub mod scalar;
pub mod start;
pub mod statistics;
pub mod synthetic;
#[cfg(test)]
mod testing;
pub mod unknowns;

pub use engine::{Options, Progress, Quiet, fit, fit_from, normal_equations, predict};
pub use experiment::Experiment;
pub use fit::{Bound, Estimate, ExperimentFit, Fit, Termination};
pub use levenberg::Limits;
pub use model::{ActiveLimit, Description, Model, ModelParameter, Sample};
pub use normal::Normal;
pub use problem::{IdentifyError, Problem, Role, Scope, Spec};
pub use recording::{Hold, Recording, RecordingError};
