//! Statistics of residuals: figures of merit, correlations, information criteria and tests.
//!
//! They are computed from recorded and predicted values alone. Samples may be uneven or missing
//! (NaN): correlations assign them to time slots.

pub mod correlation;
pub mod criteria;
pub mod delay;
pub mod distributions;
pub mod loss;
pub mod quality;
pub mod slots;

pub use correlation::{Correlations, Whiteness};
pub use criteria::Criteria;
pub use loss::LossDifference;
pub use quality::{Quality, Theil};
pub use slots::Slots;

#[cfg(test)]
pub(crate) mod tests {
    use model_core::sensors::noise::Noise;

    /// Seeded white noise of variance 1.
    pub fn white(samples: usize, seed: u64) -> Vec<f64> {
        let mut noise = Noise::new(seed, 0);
        (0..samples).map(|_| noise.gaussian(1.0)).collect()
    }
}
