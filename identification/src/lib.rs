//! Estimates the parameters of actuator models from recordings: output-error identification in the
//! time domain.
//!
//! The model is simulated on the recorded command and its angle is compared with the recorded one;
//! the estimates minimise the sum of squared residuals (Ljung, System Identification, 2nd ed.,
//! section 7.2; Maine and Iliff, NASA RP-1138: output error).
//!
//! [`Recording`] is a measurement, [`Experiment`] the same prepared for simulation, [`Model`] the
//! model, [`Problem`] the choice of free parameters, [`Fit`] the result. A model is one file:
//! [`models`] says how to add one.
//!
//! The crate is at the top level because it needs only `model-core`: command line, Python and the
//! study use it without the simulator, and the simulator's pages present its results.

mod arrow;
pub mod assessment;
mod blocks;
pub mod bounded_file;
pub mod command;
pub mod compare;
pub mod consistency;
pub mod contradictions;
mod covariance;
pub mod data;
pub mod design;
pub mod document;
pub mod engine;
pub mod evaluation;
pub mod experiment;
pub mod experiment_fit;
pub mod export;
pub mod fit;
pub mod frequency;
pub mod hybrid;
pub mod levenberg;
pub mod limited;
pub mod loss;
pub mod misfit;
pub mod model;
pub mod models;
pub mod normal;
mod observable;
pub mod parameter_file;
pub mod problem;
pub mod recording;
pub mod request;
pub mod scalar;
pub mod screening;
pub mod start;
pub mod statistics;
pub mod synthetic;
#[cfg(test)]
mod testing;
pub mod unknowns;

pub use engine::{Options, Progress, Quiet, fit, fit_from, normal_equations, predict};
pub use experiment::Experiment;
pub use experiment_fit::ExperimentFit;
pub use fit::{Bound, Estimate, Fit};
pub use levenberg::{Limits, Termination};
pub use model::{ActiveLimit, COMMANDS_PER_PASS, Description, Model, ModelParameter, Sample};
pub use normal::Normal;
pub use problem::{IdentifyError, Problem, Role, Scope, Spec};
pub use recording::{Hold, Recording, RecordingError};
