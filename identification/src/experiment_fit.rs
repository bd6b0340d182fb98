//! A model against one recording.

use super::model::ActiveLimit;

/// The fit of one experiment.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExperimentFit {
    /// Name of the recording.
    pub name: String,
    /// The model's angle at the samples of the recording, deg.
    pub predicted_deg: Vec<f64>,
    /// Recorded less predicted angle, deg; NaN where no angle was recorded.
    pub residual_deg: Vec<f64>,
    /// The active limits at the samples.
    pub state: Vec<ActiveLimit>,
    /// `100 (1 - |residual|/|angle - mean|)`: the NRMSE fit, %.
    pub fit_percent: f64,
    /// Time in which the rate was limited, s.
    pub rate_limited_s: f64,
    /// Samples that a robust loss gives less than a tenth of the weight of the others.
    pub outliers: Vec<usize>,
}

impl ExperimentFit {
    /// Mean magnitude of the residuals, deg.
    pub fn mean_absolute_error_deg(&self) -> f64 {
        let compared = || self.residual_deg.iter().filter(|r| !r.is_nan());
        compared().map(|r| r.abs()).sum::<f64>() / compared().count() as f64
    }
}
