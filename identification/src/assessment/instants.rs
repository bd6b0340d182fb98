//! The error of the instants of samples.
//!
//! An error in time is one of the angle in proportion to the rate, independent from sample to
//! sample: the second differences of the residuals show it. Estimates follow it from about half an
//! interval on, where the angle between two instants is no longer straight.

use super::Assessed;
use crate::statistics::slots::median_step_s;

/// Fewest residuals that show it.
const LEAST: usize = 50;
/// Error of the instants, in intervals, from which it biases the estimates.
const CONSIDERABLE: f64 = 0.5;

/// The error, s rms, if it is considerable.
pub fn error_s(run: &Assessed) -> Option<f64> {
    let (time_s, fit) = (&run.recording.time_s, &run.fit);
    let at = |i: usize| {
        let [before, here, after] = [i - 1, i, i + 1].map(|k| fit.residual_deg[k]);
        let square = (after - 2.0 * here + before).powi(2) / 6.0;
        let moved = fit.predicted_deg[i + 1] - fit.predicted_deg[i - 1];
        ((moved / (time_s[i + 1] - time_s[i - 1])).powi(2), square)
    };
    let inner = 1..time_s.len().saturating_sub(1);
    let mut pairs: Vec<(f64, f64)> = inner.map(at).filter(|pair| !pair.1.is_nan()).collect();
    if pairs.len() < LEAST {
        return None;
    }
    pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let slow = &pairs[..pairs.len() / 2];
    let noise = slow.iter().map(|(_, square)| square).sum::<f64>() / slow.len() as f64;
    let sums = pairs.iter().fold((0.0, 0.0), |sums, (rate, square)| {
        (sums.0 + rate * (square - noise), sums.1 + rate * rate)
    });
    let error_s = (sums.0 / sums.1).sqrt();
    (error_s > CONSIDERABLE * median_step_s(time_s)?).then_some(error_s)
}
