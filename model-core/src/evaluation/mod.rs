//! Evaluation of runs: figures of merit of steps ([`step_metrics`]), and gain and phase of sines
//! ([`frequency_response`]).

pub mod frequency_response;
pub mod step_metrics;
