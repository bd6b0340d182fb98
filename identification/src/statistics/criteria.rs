//! Information criteria.

/// Information criteria of a least-squares fit with estimated noise variance. Lower is better; only
/// differences between models of the same data are meaningful.
///
/// H. Akaike, IEEE TAC 19 (1974); G. Schwarz, Annals of Statistics 6 (1978); L. Ljung, System
/// Identification, 2nd ed. (1999), section 16.4.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Criteria {
    /// `N ln(S/N) + 2 k`.
    pub aic: f64,
    /// `N ln(S/N) + k ln N`.
    pub bic: f64,
}

impl Criteria {
    /// For `samples` residuals with this sum of squares and `parameters` estimated parameters. The
    /// noise variance counts as one more parameter.
    ///
    /// ```
    /// use identification::statistics::Criteria;
    /// let (small, large) = (Criteria::new(100, 1.0, 2), Criteria::new(100, 1.0, 3));
    /// assert!((large.aic - small.aic - 2.0).abs() < 1e-12);
    /// assert!((large.bic - small.bic - 100.0_f64.ln()).abs() < 1e-12);
    /// ```
    pub fn new(samples: usize, sum_of_squares: f64, parameters: usize) -> Self {
        let n = samples as f64;
        let variance = sum_of_squares / n;
        let k = (parameters + 1) as f64;
        Self {
            aic: n * variance.ln() + 2.0 * k,
            bic: bic(n, variance, parameters),
        }
    }
}

/// The BIC of residuals with this mean square and number of independent samples: with all samples,
/// coloured residuals would exaggerate differences of the BIC. Models are compared with the same
/// number of samples.
pub fn bic(independent_samples: f64, mean_square: f64, parameters: usize) -> f64 {
    let k = (parameters + 1) as f64;
    independent_samples * mean_square.ln() + k * independent_samples.ln()
}

/// The evidence of a difference of the BIC against the model with the larger one, in words.
///
/// R. E. Kass and A. E. Raftery, Bayes Factors, JASA 90 (1995), section 3.2.
pub fn evidence(bic_difference: f64) -> &'static str {
    match bic_difference {
        d if d < 2.0 => "not worth more than a bare mention",
        d if d < 6.0 => "positive",
        d if d < 10.0 => "strong",
        _ => "very strong",
    }
}
