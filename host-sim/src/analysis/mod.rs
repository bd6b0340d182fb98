//! Analysis of models and traces.
//!
//! From parameters, exact for small signals: frequency responses ([`frequency`]) of the linear
//! models ([`linear_models`]), stability and margins of their loops ([`loop_gain`]), and their
//! stability with other motors ([`robustness`]).
//! What is evaluated from samples is in [`model_core::evaluation`].
//!
//! Continuous and sampled systems have one type, [`transfer_function::TransferFunction`]: a
//! rational function of the delta operator `(z - 1)/T`, which is `s` for `T = 0`.

pub mod frequency;
pub mod linear_models;
pub mod loop_gain;
pub mod polynomial;
pub mod robustness;
pub mod transfer_function;

#[cfg(test)]
pub(crate) mod referee;
