//! The report: every model on every input of the paper, in one HTML file.
//!
//! [`Comparison::of`] runs and evaluates [`models::MODELS`]; [`document::page`] makes the page and
//! [`tables::all`] the tables.

mod bode;
pub mod comparison;
pub mod contradictions;
mod curves;
pub mod document;
mod input_sections;
pub mod metrics;
pub mod models;
mod responses;
pub mod runs;
pub mod small_signal;
mod stability;
mod sweep;
pub mod tables;

pub use comparison::Comparison;

#[cfg(test)]
mod tests;
