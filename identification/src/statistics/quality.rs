//! Figures of merit of a prediction.

/// Theil's inequality coefficient and the parts of the mean square error.
///
/// H. Theil, Economic Forecasts and Policy (1961), chapter 2; R. V. Jategaonkar, Flight Vehicle
/// System Identification (2006), section 11.2.3: below 0.25 to 0.3 the agreement is good; of the
/// parts, the covariance should be the largest, bias and variance near zero.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Theil {
    /// `rms(y - p)/(rms(y) + rms(p))`: 0 for an exact prediction, 1 for none.
    pub inequality: f64,
    /// Share of the mean square error that comes from the difference of the means.
    pub bias: f64,
    /// Share that comes from the difference of the standard deviations.
    pub variance: f64,
    /// Share that comes from lack of correlation. The three shares sum to 1.
    pub covariance: f64,
}

/// Figures of merit of a prediction of an angle.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Quality {
    /// Number of compared samples.
    pub samples: usize,
    /// `100 (1 - |y - p|/|y - mean y|)`, the normalised root mean square error as a fit, %; Ljung,
    /// System Identification Toolbox, `compare`. Negative where the mean would predict better.
    pub fit_percent: f64,
    /// Variance accounted for, `100 (1 - var(y - p)/var y)`, %: a bias does not count.
    pub vaf_percent: f64,
    /// Root mean square error, deg.
    pub rms_deg: f64,
    /// Mean absolute error, deg.
    pub mean_absolute_deg: f64,
    /// Largest absolute error, deg.
    pub largest_deg: f64,
    /// Mean of measured less predicted, deg.
    pub bias_deg: f64,
    /// Theil's coefficient and its parts.
    pub theil: Theil,
}

impl Quality {
    /// Compares a prediction with the measurement, at the samples that both have. `None` without
    /// such samples.
    ///
    /// ```
    /// use identification::statistics::Quality;
    /// let quality = Quality::of(&[0.0, 10.0, 0.0, 10.0], &[1.0, 9.0, 1.0, 9.0]).unwrap();
    /// // Every error is 1 deg of the 5 deg around the mean.
    /// assert!((quality.fit_percent - 80.0).abs() < 1e-12);
    /// ```
    pub fn of(measured: &[f64], predicted: &[f64]) -> Option<Self> {
        let pairs = || {
            let pairs = measured.iter().copied().zip(predicted.iter().copied());
            pairs.filter(|(y, p)| y.is_finite() && p.is_finite())
        };
        let samples = pairs().count();
        if samples == 0 {
            return None;
        }
        let mean = |f: &dyn Fn((f64, f64)) -> f64| pairs().map(f).sum::<f64>() / samples as f64;
        let (mean_y, mean_p) = (mean(&|(y, _)| y), mean(&|(_, p)| p));
        // Relative to the means, to avoid cancellation far from zero.
        let variance_y = mean(&|(y, _)| (y - mean_y).powi(2));
        let variance_p = mean(&|(_, p)| (p - mean_p).powi(2));
        let square = mean(&|(y, p)| (y - p).powi(2));
        let bias = mean_y - mean_p;
        let scatter = mean(&|(y, p)| (y - p - bias).powi(2));
        let squares = [mean(&|(y, _)| y * y), mean(&|(_, p)| p * p), square];
        Some(Self {
            samples,
            fit_percent: 100.0 * (1.0 - (square / variance_y).sqrt()),
            vaf_percent: 100.0 * (1.0 - scatter / variance_y),
            rms_deg: square.sqrt(),
            mean_absolute_deg: mean(&|(y, p)| (y - p).abs()),
            largest_deg: pairs().fold(0.0, |largest, (y, p)| largest.max((y - p).abs())),
            bias_deg: bias,
            theil: Theil::new(squares, bias, variance_y.sqrt() - variance_p.sqrt()),
        })
    }
}

impl Theil {
    /// From the mean squares of measured, predicted and error, and the differences of the means
    /// and of the standard deviations.
    fn new([y, p, error]: [f64; 3], bias: f64, deviation: f64) -> Self {
        if error == 0.0 {
            let [inequality, bias, variance, covariance] = [0.0; 4];
            return Self {
                inequality,
                bias,
                variance,
                covariance,
            };
        }
        let (bias, variance) = (bias * bias / error, deviation * deviation / error);
        Self {
            inequality: error.sqrt() / (y.sqrt() + p.sqrt()),
            bias,
            variance,
            covariance: 1.0 - bias - variance,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn an_offset_is_all_bias_and_a_wrong_amplitude_all_variance() {
        let y: Vec<f64> = (0..1000).map(|i| (0.0628 * f64::from(i)).sin()).collect();
        let shifted: Vec<f64> = y.iter().map(|y| y + 0.3).collect();
        let of_shift = Quality::of(&y, &shifted).expect("numbers");
        assert!((of_shift.theil.bias - 1.0).abs() < 1e-12);
        assert!((of_shift.vaf_percent - 100.0).abs() < 1e-9);
        assert!((of_shift.bias_deg + 0.3).abs() < 1e-12);

        let mean = y.iter().sum::<f64>() / 1000.0;
        let small: Vec<f64> = y.iter().map(|y| mean + 0.5 * (y - mean)).collect();
        let of_gain = Quality::of(&y, &small).expect("numbers");
        assert!((of_gain.theil.variance - 1.0).abs() < 1e-9);
        assert!((of_gain.fit_percent - 50.0).abs() < 1e-9);
        assert!((of_gain.vaf_percent - 75.0).abs() < 1e-9);
    }

    #[test]
    fn an_exact_prediction_has_no_error_and_missing_samples_do_not_count() {
        let quality = Quality::of(&[1.0, f64::NAN, 3.0], &[1.0, 2.0, 3.0]).expect("two numbers");
        assert_eq!((quality.samples, quality.fit_percent), (2, 100.0));
        assert_eq!(quality.theil.inequality, 0.0);
        assert_eq!(Quality::of(&[f64::NAN], &[1.0]), None);
        assert_eq!(Quality::of(&[], &[]), None);
    }

    proptest! {
        #[test]
        fn the_parts_of_the_error_are_shares_that_sum_to_one(
            pairs in prop::collection::vec((-100.0..100.0f64, -100.0..100.0f64), 2..50),
        ) {
            let (y, p): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
            let quality = Quality::of(&y, &p).unwrap();
            let Theil { inequality, bias, variance, covariance } = quality.theil;
            // Rounding: the squares of 100 against each other.
            prop_assert!((0.0..=1.0 + 1e-9).contains(&inequality));
            for part in [bias, variance, covariance] {
                prop_assert!((-1e-6..=1.0 + 1e-6).contains(&part), "{part}");
            }
            prop_assert!(quality.mean_absolute_deg <= quality.rms_deg * (1.0 + 1e-12));
        }
    }
}
