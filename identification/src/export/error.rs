//! Why a model cannot be exported.

use model_core::parameter::ParameterError;

use crate::problem::IdentifyError;

/// The range of the period of a simulation, s.
pub(super) const SHORTEST_S: f64 = 1e-4;
pub(super) const LONGEST_S: f64 = 0.05;

/// Why a model cannot be exported.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExportError {
    /// The model cannot be simulated.
    #[error("the model cannot be simulated: {0}")]
    Model(#[from] ParameterError),
    /// The law cannot be fitted.
    #[error("{target} cannot be fitted to the response of the model: {error}")]
    Fit {
        /// The target.
        target: &'static str,
        /// The reason.
        error: IdentifyError,
    },
    /// The period is not one of a simulation.
    #[error("the period is {0} s, expected {SHORTEST_S} to {LONGEST_S} s")]
    Step(f64),
    /// The best approximation is no approximation.
    #[error(
        "{target} cannot represent this model: its best approximation on the inputs {} and {} \
         is {error_deg:.3} deg rms from a response with a standard deviation of {spread_deg:.3} deg \
         to the input {input}, expected at most half of that", fitted_to[0], fitted_to[1]
    )]
    Unlike {
        /// The target.
        target: &'static str,
        /// Its error, deg rms.
        error_deg: f64,
        /// The standard deviation of the response, deg.
        spread_deg: f64,
        /// The input of the error.
        input: &'static str,
        /// The inputs of the fit.
        fitted_to: [&'static str; 2],
    },
}
