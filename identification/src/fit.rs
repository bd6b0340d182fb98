//! The result of an identification.

use nalgebra::DMatrix;

use super::consistency::Consistency;
use super::experiment::Assumptions;
use super::experiment_fit::ExperimentFit;
use super::levenberg::Termination;
use super::loss::Loss;

/// A bound that an estimate is at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// The lower one.
    Low,
    /// The upper one.
    High,
}

/// An estimated or fixed parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The parameter's name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The index of the experiment that has it; `None` where all share it.
    pub experiment: Option<usize>,
    /// Its value.
    pub value: f64,
    /// Its starting value.
    pub start: f64,
    /// Its bounds.
    pub bounds: (f64, f64),
    /// Whether it was fixed.
    pub fixed: bool,
    /// Cramer-Rao standard error for white residuals; NaN where it is fixed, at its bound, or not
    /// identifiable.
    pub standard_error: f64,
    /// The same for residuals that are correlated in time.
    pub standard_error_coloured: f64,
    /// The bound that it is at.
    pub at_bound: Option<Bound>,
    /// Whether the experiments determine it.
    pub identifiable: bool,
    /// Where it is at a bound, the end of its 95 % interval by the profile likelihood; NaN where it
    /// has a standard error or no influence.
    pub profile: f64,
}

impl Estimate {
    /// Whether it was searched for in vain: the experiments do not determine it, or it is at a bound
    /// of its range.
    pub fn is_undetermined(&self) -> bool {
        !self.fixed && (!self.identifiable || self.at_bound.is_some())
    }
}

/// A fitted model.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Name of the model.
    pub model: &'static str,
    /// All parameters, the fixed ones included.
    pub estimates: Vec<Estimate>,
    /// The indices of the estimates in the rows of the matrices: those with a standard error.
    pub rows: Vec<usize>,
    /// Covariance of the estimates for white residuals.
    pub covariance: DMatrix<f64>,
    /// The same for residuals that are correlated in time.
    pub covariance_coloured: DMatrix<f64>,
    /// Correlation of the estimates, from the first of the two.
    pub correlation: DMatrix<f64>,
    /// One for each experiment.
    pub experiments: Vec<ExperimentFit>,
    /// How residuals counted.
    pub loss: Loss,
    /// Half the sum of squared residuals, deg^2, or of their losses where these are not squares.
    pub cost: f64,
    /// Number of residuals.
    pub samples: usize,
    /// Standard deviation of the residuals with the degrees of freedom of the parameters
    /// subtracted, deg.
    pub noise_deg: f64,
    /// `100 (1 - |residual|/|angle - mean|)` over all experiments, %.
    pub fit_percent: f64,
    /// Iterations of the search.
    pub iterations: usize,
    /// The reason why the search ended.
    pub termination: Termination,
    /// Number of starting points, and how many of them ended in this optimum.
    pub starts: (usize, usize),
    /// The assumptions about the recordings.
    pub assumptions: Assumptions,
    /// Whether a zero-order hold of the command fits as well as the assumed smooth command: the
    /// delay is then determined to half a sample only.
    pub is_hold_undetermined: bool,
    /// The nested model that fits as well by a likelihood-ratio test: the estimates are its
    /// optimum, and the additional parameters have no effect.
    pub no_better_than: Option<&'static str>,
    /// Whether all parts of the recordings agree about the parameters.
    pub consistency: Consistency,
}

impl Fit {
    /// Whether the values are those of an optimum.
    pub fn has_converged(&self) -> bool {
        self.termination == Termination::Converged
    }

    /// The estimate of this name, of an experiment where it has its own.
    pub fn estimate(&self, name: &str) -> Option<&Estimate> {
        self.estimates.iter().find(|e| e.name == name)
    }

    /// The value of the estimate of this name.
    pub fn value(&self, name: &str) -> Option<f64> {
        Some(self.estimate(name)?.value)
    }
}
