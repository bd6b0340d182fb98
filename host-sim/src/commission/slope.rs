//! The slope of a line through points, by least squares.

use super::Estimate;

/// The slope, with the standard error of the residuals; `None` for fewer than three points, or for
/// points at one place.
pub fn slope(points: &[(f64, f64)]) -> Option<Estimate> {
    let count = points.len() as f64;
    let mean_x = points.iter().map(|(x, _)| x).sum::<f64>() / count;
    let mean_y = points.iter().map(|(_, y)| y).sum::<f64>() / count;
    let square: f64 = points.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    if points.len() < 3 || square <= 0.0 {
        return None;
    }
    let product = |(x, y): &(f64, f64)| (x - mean_x) * (y - mean_y);
    let value = points.iter().map(product).sum::<f64>() / square;
    let residual = |(x, y): &(f64, f64)| y - mean_y - value * (x - mean_x);
    let variance = points.iter().map(|p| residual(p).powi(2)).sum::<f64>() / (count - 2.0);
    Some(Estimate {
        value,
        standard_error: (variance / square).sqrt(),
    })
}
