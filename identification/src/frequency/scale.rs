//! Scales of a Bode plot.

pub use model_core::evaluation::frequency_response::{decibel, unwrap_deg};

/// Frequencies from `from_hz` to `to_hz`, both included, evenly spaced on a logarithmic axis; none
/// where that is not possible.
///
/// ```
/// let grid = identification::frequency::logarithmic_grid(0.1, 10.0, 1);
/// assert_eq!(grid.len(), 3);
/// assert!((grid[1] - 1.0).abs() < 1e-12);
/// ```
pub fn logarithmic_grid(from_hz: f64, to_hz: f64, points_per_decade: usize) -> Vec<f64> {
    if !(from_hz > 0.0 && to_hz > from_hz && to_hz.is_finite()) || points_per_decade == 0 {
        return Vec::new();
    }
    let steps = ((to_hz / from_hz).log10() * points_per_decade as f64).ceil();
    (0..=steps as usize)
        .map(|i| from_hz * (to_hz / from_hz).powf(i as f64 / steps))
        .collect()
}
