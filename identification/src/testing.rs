//! Recordings with a known truth, for tests.

pub use super::synthetic::noisy;
use super::{recording::Recording, synthetic};
use model_core::actuator::ModelKind;

/// What the simulator makes of an input, as a recording with a row of every `every`th tick.
pub fn simulated(kind: ModelKind, input: &str, every: u64, set: &[(&str, f64)]) -> Recording {
    synthetic::simulated(kind, input, every, set).expect("a run")
}
