//! Evaluation of runs, the same for the report and for the page in the browser: figures of merit of
//! steps ([`step_metrics`]) and the measured frequency response ([`frequency_response`]).

pub mod frequency_response;
pub mod step_metrics;
