//! Nonparametric identification in the frequency domain.
//!
//! [`FrequencyResponse`] is the response by Welch's method, with coherence and confidence;
//! [`Equivalent`] is the low-order system that fits it best. Both assume a linear system:
//! recordings at the rate limit give the describing function of that amplitude, not the
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
