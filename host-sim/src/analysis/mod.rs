//! What a control engineer asks of a model or of a trace.
//!
//! From parameters, small-signal and exact: frequency responses ([`frequency`]) of the linear
//! models ([`linear_models`]), and the margins and the stability of their loops ([`loop_gain`]).
//! From samples: step figures ([`step_metrics`]) and gain and phase at a frequency ([`sine_fit`]).
//!
//! Continuous and sampled systems are one type, [`transfer_function::TransferFunction`]: a rational
//! function of the delta operator `(z - 1)/T`, which becomes `s` where `T` is zero.

pub mod frequency;
pub mod linear_models;
pub mod loop_gain;
pub mod polynomial;
pub mod sine_fit;
pub mod step_metrics;
pub mod transfer_function;

#[cfg(test)]
pub(crate) mod referee;
