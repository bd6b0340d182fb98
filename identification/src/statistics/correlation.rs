//! Whiteness of residuals, and their correlation with the input.
//!
//! The residuals of an exact model are white and not correlated with the input. L. Ljung, System
//! Identification, 2nd ed. (1999), section 16.6. Output-error estimates are unbiased without white
//! residuals; their standard errors are not. A correlation with the input at positive lags means
//! dynamics that the model lacks, at negative lags feedback or a wrong delay.

use super::{
    distributions::{COVERED, chi_squared_exceeds, two_sided},
    slots::{LaggedProducts, Slots, lagged_products},
};

/// Correlations of the residuals of one experiment, each with its 95 % confidence band.
#[derive(Debug, Clone, PartialEq)]
pub struct Correlations {
    /// Lags of the autocorrelation, s, from 0 on.
    pub auto_lag_s: Vec<f64>,
    /// Autocorrelation of the residual, 1 at lag 0; NaN without a pair of samples at that lag.
    pub auto: Vec<f64>,
    /// Half-width of its band: `1.96/sqrt(pairs)`.
    pub auto_band: Vec<f64>,
    /// Lags of the cross-correlation, s; positive where the residual follows the input.
    pub cross_lag_s: Vec<f64>,
    /// Correlation of the residual with the changes of the input, which are nearly white for a step
    /// or a held sequence, so that missing dynamics appear at their lag.
    pub cross: Vec<f64>,
    /// Half-width of its band. Residual and input may both be coloured: the variance is the sum of
    /// the products of their autocorrelations over the pairs (Ljung, eq. 16.63).
    pub cross_band: Vec<f64>,
    /// The test of the autocorrelation.
    pub whiteness: Whiteness,
    /// The largest cross-correlation in units of its band, at lags from 0 on.
    pub cross_ratio: f64,
    /// The equivalent number of independent samples: `N/(1 + 2 sum rho)`.
    pub effective_samples: f64,
}

/// The portmanteau test of an autocorrelation: `sum n rho^2` is chi-squared if the residuals are
/// white (G. E. P. Box and D. A. Pierce, JASA 65, 1970; Ljung, eq. 16.61).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Whiteness {
    /// The sum over the lags.
    pub statistic: f64,
    /// Number of lags.
    pub lags: usize,
    /// Probability that white residuals exceed it.
    pub p_value: f64,
    /// Share of the lags outside the band; 0.05 is expected of white residuals.
    pub outside: f64,
}

/// Lags of the test: the customary 25.
const TESTED_LAGS: usize = 25;
/// Significance level of the test: 0.01, as in Ljung's toolbox.
const LEAST_P: f64 = 0.01;
/// Longest lag, s: beyond the impulse response of a servo.
const LONGEST_LAG_S: f64 = 1.0;
/// Largest number of lags.
const MOST_LAGS: usize = 1000;

impl Whiteness {
    /// Whether the test does not reject white residuals.
    pub fn is_white(&self) -> bool {
        self.p_value >= LEAST_P
    }
}

impl Correlations {
    /// The correlations of a residual with itself and with the changes of the input. `None` where
    /// there are too few residuals, or all are equal.
    ///
    /// ```
    /// use identification::statistics::Correlations;
    /// let time_s: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.02).collect();
    /// let residual: Vec<f64> = (0..100).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
    /// let correlations = Correlations::of(&time_s, &residual, &time_s).unwrap();
    /// assert!((correlations.auto[1] + 1.0).abs() < 1e-9);
    /// assert!(!correlations.whiteness.is_white());
    /// ```
    pub fn of(time_s: &[f64], residual: &[f64], input: &[f64]) -> Option<Self> {
        let mut slots = Slots::new(time_s, &[residual, input], LONGEST_LAG_S)?;
        slots.held(1);
        if let Some(input) = slots.columns.get_mut(1) {
            take_changes(input);
        }
        let (e, u) = (&slots.columns[0], &slots.columns[1]);
        let samples = e.iter().filter(|v| v.is_finite()).count();
        let lags = shown_lags(samples, &slots);
        let auto = Normalised::new(&lagged_products(e, e, lags), None)?;
        let scale = (auto.variance, lagged_products(u, u, 0));
        let variance_u = scale.1.sums[0] / scale.1.pairs[0].max(1.0);
        let seconds = |lag: isize| lag as f64 * slots.step_s;
        let effective_samples = samples as f64 / auto.correlation_length();
        let mut this = Self {
            auto_lag_s: (0..=lags as isize).map(seconds).collect(),
            auto_band: auto.bands(1.0),
            whiteness: auto.whiteness(),
            auto: auto.values,
            cross_lag_s: Vec::new(),
            cross: Vec::new(),
            cross_band: Vec::new(),
            cross_ratio: 0.0,
            effective_samples,
        };
        // A constant input has no correlation.
        if variance_u > 0.0 {
            let deviation = (scale.0 * variance_u).sqrt();
            this.cross(e, u, lags, deviation);
            this.cross_lag_s = (-(lags as isize)..=lags as isize).map(seconds).collect();
        }
        Some(this)
    }

    fn cross(&mut self, e: &[f64], u: &[f64], lags: usize, deviation: f64) {
        let products = [lagged_products(u, e, lags), lagged_products(e, u, lags)];
        let halves = products.map(|p| Normalised::new(&p, Some(deviation)));
        let [Some(before), Some(after)] = halves else {
            return;
        };
        let inflation = joint_colour(e, u);
        let earlier = |half: &[f64]| half.iter().skip(1).rev().copied().collect::<Vec<f64>>();
        self.cross = [earlier(&before.values), after.values.clone()].concat();
        let (bands_before, bands_after) = (before.bands(inflation), after.bands(inflation));
        self.cross_ratio = after
            .values
            .iter()
            .zip(&bands_after)
            .map(|(value, band)| value.abs() / band)
            .filter(|ratio| ratio.is_finite())
            .fold(0.0, f64::max);
        self.cross_band = [earlier(&bands_before), bands_after].concat();
    }

    /// Whether the residual is correlated with the input: at any lag at the level of 0.01, with
    /// Bonferroni's correction for the number of lags.
    pub fn is_correlated_with_input(&self) -> bool {
        let lags = (self.cross.len() / 2 + 1) as f64;
        self.cross_ratio > two_sided(1.0 - 0.01 / lags) / two_sided(COVERED)
    }
}

/// The changes from slot to slot.
fn take_changes(input: &mut [f64]) {
    let mut before = input.first().copied().unwrap_or(f64::NAN);
    for value in input {
        (*value, before) = (*value - before, *value);
    }
}

/// The number of lags, at most a quarter of the samples: beyond, too few pairs remain.
fn shown_lags(samples: usize, slots: &Slots) -> usize {
    let wanted = slots.longest_lag.max(TESTED_LAGS);
    wanted.min(samples / 4).clamp(1, MOST_LAGS)
}

/// A correlation normalised by that at lag 0.
struct Normalised {
    values: Vec<f64>,
    pairs: Vec<f64>,
    variance: f64,
}

impl Normalised {
    /// Divided by `deviation`, or by the value at lag 0.
    fn new(products: &LaggedProducts, deviation: Option<f64>) -> Option<Self> {
        let LaggedProducts { sums, pairs } = products;
        let means = sums.iter().zip(pairs);
        let means: Vec<f64> = means
            .map(|(sum, pairs)| if *pairs > 0.0 { sum / pairs } else { f64::NAN })
            .collect();
        let variance = deviation.unwrap_or(*means.first()?);
        (variance > 0.0).then(|| Self {
            values: means.iter().map(|mean| mean / variance).collect(),
            pairs: pairs.clone(),
            variance,
        })
    }

    fn bands(&self, inflation: f64) -> Vec<f64> {
        let band = |pairs: &f64| two_sided(COVERED) * (inflation / pairs).sqrt();
        self.pairs.iter().map(band).collect()
    }

    fn whiteness(&self) -> Whiteness {
        let lags = self.values.iter().zip(&self.pairs).skip(1);
        let tested = lags
            .take(TESTED_LAGS)
            .filter(|(value, _)| value.is_finite());
        let squares: Vec<f64> = tested.map(|(value, n)| n * value * value).collect();
        let (statistic, lags) = (squares.iter().sum(), squares.len());
        let outside = squares.iter().filter(|s| s.sqrt() > two_sided(COVERED));
        Whiteness {
            statistic,
            lags,
            p_value: chi_squared_exceeds(statistic, lags as f64),
            outside: outside.count() as f64 / lags.max(1) as f64,
        }
    }

    /// `1 + 2 sum rho` up to the first pair of lags with a negative sum: the rest is noise (C. J.
    /// Geyer, Statistical Science 7, 1992).
    fn correlation_length(&self) -> f64 {
        let pairs = self
            .values
            .as_chunks()
            .0
            .iter()
            .map(|[a, b]: &[f64; 2]| a + b);
        let sum: f64 = pairs.take_while(|sum| *sum > 0.0).sum();
        (2.0 * sum - 1.0).max(1.0)
    }
}

/// The sum of the products of two autocorrelations over all lags: the factor of the variance of a
/// cross-correlation against that of white signals.
fn joint_colour(e: &[f64], u: &[f64]) -> f64 {
    let longest = e.len() / 4;
    let of = |signal| Normalised::new(&lagged_products(signal, signal, longest), None);
    let (Some(e), Some(u)) = (of(e), of(u)) else {
        return 1.0;
    };
    let products = e.values.iter().zip(&u.values).skip(1);
    let sum: f64 = products.map(|(e, u)| e * u).filter(|p| p.is_finite()).sum();
    // The estimated sum may be below that of white signals; the band must not vanish.
    (1.0 + 2.0 * sum).max(1.0)
}

#[cfg(test)]
#[path = "correlation_tests.rs"]
mod tests;
