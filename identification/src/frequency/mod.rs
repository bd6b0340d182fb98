//! A second opinion in the frequency domain: no model, no start values, no search.
//!
//! [`FrequencyResponse`] is what the recordings say by Welch's method, with coherence and confidence;
//! [`Equivalent`] is the lag of low order that comes nearest to it. Both are of a linear system:
//! recordings at the rate limit give the describing function of that amplitude, not the actuator's
//! small-signal response.

pub mod equivalent;
pub mod grid;
pub mod response;
mod scale;

pub use equivalent::{Equivalent, Shape};
pub use response::FrequencyResponse;
pub use scale::{decibel, logarithmic_grid, unwrap_deg};

#[cfg(test)]
mod tests;
