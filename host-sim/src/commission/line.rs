//! A line through points by least squares.

use super::Estimate;

/// Offset and slope of the line through points, with the standard errors of their residuals;
/// `None` for fewer than three points, or for points at one place.
///
/// ```text
/// points (0, 1), (1, 3), (2, 5), (3, 7): offset 1, slope 2, both errors 0
/// ```
pub fn line(points: &[(f64, f64)]) -> Option<(Estimate, Estimate)> {
    let count = points.len() as f64;
    let mean_x = points.iter().map(|(x, _)| x).sum::<f64>() / count;
    let mean_y = points.iter().map(|(_, y)| y).sum::<f64>() / count;
    let square: f64 = points.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    if points.len() < 3 || square <= 0.0 {
        return None;
    }
    let product = |(x, y): &(f64, f64)| (x - mean_x) * (y - mean_y);
    let slope = points.iter().map(product).sum::<f64>() / square;
    let residual = |(x, y): &(f64, f64)| y - mean_y - slope * (x - mean_x);
    let variance = points.iter().map(|p| residual(p).powi(2)).sum::<f64>() / (count - 2.0);
    let offset = Estimate {
        value: mean_y - slope * mean_x,
        standard_error: (variance * (1.0 / count + mean_x * mean_x / square)).sqrt(),
    };
    let standard_error = (variance / square).sqrt();
    let slope = Estimate {
        value: slope,
        standard_error,
    };
    Some((offset, slope))
}
