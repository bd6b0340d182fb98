//! The outcome of an identification.

use nalgebra::DMatrix;

use super::experiment::Reading;
use super::model::ActiveLimit;

/// A bound that an estimate stands at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// The lower one.
    Low,
    /// The upper one.
    High,
}

/// A parameter as it was found or given.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The parameter's name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The experiment that it belongs to alone, by number; `None` where all share it.
    pub experiment: Option<usize>,
    /// Its value.
    pub value: f64,
    /// Where the search for it began.
    pub start: f64,
    /// Its bounds.
    pub bounds: (f64, f64),
    /// Whether it was given and not looked for.
    pub fixed: bool,
    /// Cramer-Rao standard error if the residuals are white; NaN where there is none: fixed, at its
    /// bound, or not identifiable.
    pub standard_error: f64,
    /// The same for residuals that are correlated in time.
    pub standard_error_coloured: f64,
    /// The bound that it stands at.
    pub at_bound: Option<Bound>,
    /// Whether the experiments tell anything of it.
    pub identifiable: bool,
}

/// What a fit makes of one experiment.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExperimentFit {
    /// Name of the recording.
    pub name: String,
    /// The model's angle at the samples of the recording, deg.
    pub predicted_deg: Vec<f64>,
    /// Recorded less predicted angle, deg; NaN where no angle was recorded.
    pub residual_deg: Vec<f64>,
    /// The model's limits at the samples.
    pub state: Vec<ActiveLimit>,
    /// `100 (1 - |residual|/|angle - mean|)`: the NRMSE fit, %.
    pub fit_percent: f64,
    /// Time in which the rate was limited, s.
    pub rate_limited_s: f64,
}

impl ExperimentFit {
    /// Mean magnitude of the residuals, deg.
    pub fn mean_absolute_error_deg(&self) -> f64 {
        let compared = || self.residual_deg.iter().filter(|r| !r.is_nan());
        compared().map(|r| r.abs()).sum::<f64>() / compared().count() as f64
    }
}

/// Why the search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Termination {
    /// The gradient vanished, or neither cost nor parameters moved any more.
    Converged,
    /// The most iterations were made.
    IterationLimit,
    /// No step lowered the cost although the gradient does not vanish.
    Stalled,
    /// The caller stopped it.
    Interrupted,
}

/// A fitted model.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Name of the model.
    pub model: &'static str,
    /// All parameters, the fixed ones included.
    pub estimates: Vec<Estimate>,
    /// Which of the estimates the rows of the matrices stand for: those with a standard error.
    pub rows: Vec<usize>,
    /// Covariance of the estimates for white residuals.
    pub covariance: DMatrix<f64>,
    /// The same for residuals that are correlated in time.
    pub covariance_coloured: DMatrix<f64>,
    /// Correlation of the estimates, from the first of the two.
    pub correlation: DMatrix<f64>,
    /// One for each experiment.
    pub experiments: Vec<ExperimentFit>,
    /// Half the sum of squared residuals, deg^2.
    pub cost: f64,
    /// Residuals that were compared.
    pub samples: usize,
    /// Standard deviation of the residuals with the parameters' degrees of freedom taken off, deg.
    pub noise_deg: f64,
    /// `100 (1 - |residual|/|angle - mean|)` over all experiments, %.
    pub fit_percent: f64,
    /// Iterations of the search that found it.
    pub iterations: usize,
    /// Why that search ended.
    pub termination: Termination,
    /// Starts that were tried, and how many of them ended here.
    pub starts: (usize, usize),
    /// How the recordings are read.
    pub reading: Reading,
    /// Whether a command that is held from sample to sample would fit as well as the smooth one that was
    /// taken, but for chance: the delay is then known to half a sample only.
    pub is_hold_open: bool,
    /// The special case of the model that fits as well but for chance: the estimates are its own then, and
    /// what the model has beyond it does nothing.
    pub no_better_than: Option<&'static str>,
}

impl Fit {
    /// The estimate of this name, of an experiment where it has its own.
    pub fn estimate(&self, name: &str) -> Option<&Estimate> {
        self.estimates.iter().find(|e| e.name == name)
    }

    /// The value of the estimate of this name.
    pub fn value(&self, name: &str) -> Option<f64> {
        Some(self.estimate(name)?.value)
    }
}
