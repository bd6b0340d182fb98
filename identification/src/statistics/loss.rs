//! Tests whether one model predicts significantly better than another.

use super::{
    correlation::Correlations,
    distributions::{COVERED, two_sided},
};

/// The mean difference of the squared errors of two predictions, with its standard error.
///
/// F. X. Diebold and R. S. Mariano, Comparing Predictive Accuracy, Journal of Business and Economic
/// Statistics 13 (1995): the difference is a time series, and the standard error of its mean
/// follows from its number of independent samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LossDifference {
    /// Mean of the squared error of the first less that of the second, deg^2.
    pub mean_deg2: f64,
    /// Its standard error, deg^2.
    pub standard_error_deg2: f64,
}

/// Residuals of two models at the instants of one recording.
#[derive(Debug, Clone, Copy)]
pub struct Residuals<'a> {
    /// Instants, s.
    pub time_s: &'a [f64],
    /// Of the first model, deg.
    pub first_deg: &'a [f64],
    /// Of the second model, deg.
    pub second_deg: &'a [f64],
}

impl LossDifference {
    /// Compares two models on the same recordings. `None` without common samples.
    pub fn of<'a>(recordings: impl IntoIterator<Item = Residuals<'a>>) -> Option<Self> {
        let (mut sum, mut samples, mut variance_of_sum) = (0.0, 0.0, 0.0);
        for residuals in recordings {
            let squares = residuals.first_deg.iter().zip(residuals.second_deg);
            let losses: Vec<f64> = squares.map(|(a, b)| a * a - b * b).collect();
            let present = || losses.iter().filter(|loss| loss.is_finite());
            let n = present().count() as f64;
            if n < 2.0 {
                continue;
            }
            let mean = present().sum::<f64>() / n;
            let variance = present().map(|loss| (loss - mean).powi(2)).sum::<f64>() / (n - 1.0);
            let colour = Correlations::of(residuals.time_s, &losses, residuals.time_s);
            let effective = colour.map_or(n, |c| c.effective_samples);
            sum += mean * n;
            samples += n;
            variance_of_sum += n * n * variance / effective;
        }
        (samples > 0.0).then(|| Self {
            mean_deg2: sum / samples,
            standard_error_deg2: variance_of_sum.sqrt() / samples,
        })
    }

    /// The difference in standard errors; 0 for identical predictions.
    pub fn z(&self) -> f64 {
        if self.mean_deg2 == 0.0 {
            return 0.0;
        }
        self.mean_deg2 / self.standard_error_deg2
    }

    /// Whether it is not significant at the level of 0.05.
    pub fn is_by_chance(&self) -> bool {
        let z = self.z().abs();
        z.is_nan() || z <= two_sided(COVERED)
    }
}

#[cfg(test)]
mod tests {
    use super::{super::tests::white, *};

    fn difference(first: &[f64], second: &[f64]) -> LossDifference {
        let time_s: Vec<f64> = (0..first.len()).map(|i| i as f64 * 0.004).collect();
        let residuals = Residuals {
            time_s: &time_s,
            first_deg: first,
            second_deg: second,
        };
        LossDifference::of([residuals]).expect("residuals")
    }

    #[test]
    fn two_models_of_the_same_error_differ_by_chance_as_often_as_said() {
        let by_chance = (0..200)
            .filter(|&seed| difference(&white(500, seed), &white(500, seed + 1000)).is_by_chance());
        let count = by_chance.count();
        // 190 are expected; three standard deviations are 9.
        assert!((181..=199).contains(&count), "{count}");
    }

    #[test]
    fn a_model_with_a_third_more_error_is_distinguished() {
        let worse: Vec<f64> = white(500, 1).iter().map(|e| 1.33 * e).collect();
        let difference = difference(&worse, &white(500, 2));
        assert!(difference.mean_deg2 > 0.0 && !difference.is_by_chance());
    }

    #[test]
    fn a_model_is_not_distinguished_from_itself() {
        let e = white(100, 1);
        assert!(difference(&e, &e).is_by_chance());
        assert_eq!(LossDifference::of([]), None);
    }
}
