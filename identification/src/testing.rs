//! Simulated recordings for tests.

pub use super::synthetic::noisy;
use super::{recording::Recording, synthetic};
use model_core::actuator::ModelKind;

/// See [`synthetic::simulated`].
pub fn simulated(kind: ModelKind, input: &str, every: u64, set: &[(&str, f64)]) -> Recording {
    synthetic::simulated(kind, input, every, set).expect("a run")
}
