//! Quantiles and tail probabilities of the usual distributions.

use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

/// Coverage of all confidence bands: 1.96 standard deviations of a normal distribution.
pub const COVERED: f64 = 0.95;

/// Half-width of a two-sided interval of this coverage, in standard deviations.
///
/// ```
/// use identification::statistics::distributions::{COVERED, two_sided};
/// assert!((two_sided(COVERED) - 1.959964).abs() < 1e-6);
/// ```
pub fn two_sided(covered: f64) -> f64 {
    if covered > 0.0 && covered < 1.0 {
        Normal::standard().inverse_cdf(0.5 + 0.5 * covered)
    } else {
        f64::NAN
    }
}

/// Probability that a chi-squared variable with these degrees of freedom exceeds `statistic`; NaN
/// without degrees of freedom.
///
/// ```
/// use identification::statistics::distributions::chi_squared_exceeds;
/// // The 95 % quantile of 25 degrees of freedom.
/// assert!((chi_squared_exceeds(37.652, 25.0) - 0.05).abs() < 1e-5);
/// ```
pub fn chi_squared_exceeds(statistic: f64, degrees: f64) -> f64 {
    ChiSquared::new(degrees).map_or(f64::NAN, |chi_squared| chi_squared.sf(statistic))
}
