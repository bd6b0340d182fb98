//! The result of an identification.

use nalgebra::DMatrix;

use super::consistency::Consistency;
use super::experiment::Assumptions;
use super::experiment_fit::ExperimentFit;
use super::levenberg::Termination;
use super::loss::Loss;
use super::misfit::Misfit;

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
    /// Cramer-Rao standard error for white residuals; NaN where it is fixed, at its bound, or shown
    /// only in combination with others or not at all.
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
    /// Where it is at a bound, by how many of its standard errors it would be beyond it; otherwise
    /// zero.
    pub beyond: f64,
}

/// A combination of estimates that is known though no estimate in it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Combination {
    /// The indices of the estimates, and their exponents in a product or their factors in a sum;
    /// that of the first is 1.
    pub terms: Vec<(usize, f64)>,
    /// Whether it is a product of powers and not a sum.
    pub is_product: bool,
    /// Its value.
    pub value: f64,
    /// Its standard error for white residuals.
    pub standard_error: f64,
    /// The same for residuals that are correlated in time.
    pub standard_error_coloured: f64,
}

impl Estimate {
    /// Whether it was searched for in vain: the experiments do not determine it, it is at a bound
    /// of its range, or it is a positive quantity with a standard error as large as itself.
    pub fn is_undetermined(&self) -> bool {
        let error = self.standard_error.max(self.standard_error_coloured);
        let is_lost = self.bounds.0 >= 0.0 && error >= self.value;
        !self.fixed && (!self.identifiable || self.at_bound.is_some() || is_lost)
    }
}

/// A fitted model.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Name of the model.
    pub model: &'static str,
    /// All parameters, the fixed ones included.
    pub estimates: Vec<Estimate>,
    /// What is known of estimates that are not identifiable alone.
    pub combinations: Vec<Combination>,
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
    /// The residuals against the noise of the recordings.
    pub misfit: Misfit,
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
    /// Where the command may have changed before the samples that show it: how far below and above
    /// its estimate the delay may be for that reason, s; its standard errors include it.
    pub delay_open_s: Option<(f64, f64)>,
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

    /// A combination in words.
    ///
    /// The names of the estimates are joined by `*` and `/`, or by `+` and `-`.
    pub fn described(&self, combination: &Combination) -> String {
        let mut text = String::new();
        for (index, factor) in &combination.terms {
            let name = self.estimates[*index].name;
            let size = factor.abs();
            let is_one = (size - 1.0).abs() < 1e-9;
            let sign = match (text.is_empty(), combination.is_product, *factor > 0.0) {
                (true, ..) => "",
                (_, true, true) => " * ",
                (_, true, false) => " / ",
                (_, false, true) => " + ",
                (_, false, false) => " - ",
            };
            text.push_str(sign);
            text.push_str(&match (is_one, combination.is_product) {
                (true, _) => name.to_owned(),
                (false, true) => format!("{name}^{size:.3}"),
                (false, false) => format!("{size:.3e} {name}"),
            });
        }
        text
    }

    /// The value of the estimate of this name.
    pub fn value(&self, name: &str) -> Option<f64> {
        Some(self.estimate(name)?.value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_estimate_with_an_error_of_its_own_size_is_not_determined() {
        let with_errors = |white, coloured| Estimate {
            name: "inertia_kg_m2",
            unit: "kg m^2",
            experiment: None,
            value: 0.02,
            start: 0.01,
            bounds: (0.0, 1.0),
            fixed: false,
            standard_error: white,
            standard_error_coloured: coloured,
            at_bound: None,
            identifiable: true,
            profile: f64::NAN,
            beyond: 0.0,
        };
        assert!(!with_errors(0.001, 0.019).is_undetermined());
        assert!(with_errors(0.001, 0.02).is_undetermined());
        assert!(with_errors(0.03, f64::NAN).is_undetermined());
        let held = Estimate {
            fixed: true,
            ..with_errors(f64::NAN, f64::NAN)
        };
        assert!(!held.is_undetermined());
        // An offset may be zero.
        let offset = Estimate {
            bounds: (-1.0, 1.0),
            ..with_errors(0.03, 0.03)
        };
        assert!(!offset.is_undetermined());
    }
}
