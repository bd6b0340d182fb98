//! Bode plots and bandwidths of transfer functions.

pub use identification::frequency::{decibel, logarithmic_grid, unwrap_deg};
pub use model_core::evaluation::frequency_response::HALF_POWER_DB;

use super::transfer_function::TransferFunction;

// Range of all searches, Hz. The dynamics of a servo are between 0.1 and 100 Hz: three decades of
// reserve below, two above.
const LOWEST_HZ: f64 = 1e-4;
const HIGHEST_HZ: f64 = 1e4;
// 1.2 % from point to point. With the maximum delay of 8 periods the phase changes by less than 20
// degrees from point to point at the Nyquist frequency: no crossing is missed.
const SEARCH_POINTS_PER_DECADE: usize = 200;

/// A frequency response.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Response {
    /// Frequencies, Hz.
    pub frequency_hz: Vec<f64>,
    /// Gains, dB.
    pub gain_db: Vec<f64>,
    /// Phases, deg, without jumps by 360 deg.
    pub phase_deg: Vec<f64>,
}

impl Response {
    /// The response of `system` at ascending frequencies.
    ///
    /// Without the transport delay, the first phase is within 180 deg of zero, and each following
    /// one within 180 deg of the previous one: start at a low frequency.
    ///
    /// ```
    /// use host_sim::analysis::{frequency::Response, linear_models::black_box_1};
    /// let response = Response::of(&black_box_1(30.0), &[1.0, 4.7746]);
    /// assert!((response.gain_db[1] + 3.01).abs() < 0.01);
    /// assert!((response.phase_deg[1] + 45.0).abs() < 0.01);
    /// ```
    pub fn of(system: &TransferFunction, frequency_hz: &[f64]) -> Self {
        let values: Vec<_> = frequency_hz
            .iter()
            .map(|f| system.rational_at(*f))
            .collect();
        let mut phase_deg: Vec<_> = values.iter().map(|v| v.arg().to_degrees()).collect();
        unwrap_deg(&mut phase_deg);
        for (phase, f) in phase_deg.iter_mut().zip(frequency_hz) {
            *phase -= 360.0 * f * system.delay_s();
        }
        Self {
            frequency_hz: frequency_hz.to_vec(),
            gain_db: values.iter().map(|v| decibel(v.norm())).collect(),
            phase_deg,
        }
    }
}

/// The grid for the search of crossings of `system`. It ends just below the Nyquist frequency,
/// where the response is real and the sign of the imaginary part is a rounding error.
pub(crate) fn search_grid(system: &TransferFunction) -> Vec<f64> {
    let to_hz = HIGHEST_HZ.min(system.nyquist_hz() * (1.0 - 1e-6));
    logarithmic_grid(LOWEST_HZ, to_hz, SEARCH_POINTS_PER_DECADE)
}

/// The points at which `f` changes its sign along the grid, refined by bisection.
pub(crate) fn sign_changes(grid: &[f64], f: impl Fn(f64) -> f64) -> impl Iterator<Item = f64> {
    grid.windows(2).filter_map(move |ends| {
        let positive = f(ends[0]) > 0.0;
        let changes = (f(ends[1]) > 0.0) != positive;
        changes.then(|| bisect(ends[0], ends[1], |x| (f(x) > 0.0) == positive))
    })
}

/// The boundary between `low`, at which `holds` is true, and `high`, at which it is false.
pub(crate) fn bisect(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    // After 60 bisections there is no number between the limits.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// The first frequency, Hz, at which the gain of `system` is `fall_db` (negative) relative to its
/// steady-state gain. `None` if it never is or there is no steady-state gain.
pub fn falls_to_hz(system: &TransferFunction, fall_db: f64) -> Option<f64> {
    let level_db = decibel(system.steady_gain()) + fall_db;
    if !level_db.is_finite() {
        return None;
    }
    let above = |f| decibel(system.rational_at(f).norm()) - level_db;
    sign_changes(&search_grid(system), above).next()
}

/// The bandwidth, Hz: the frequency of half power.
///
/// ```
/// use host_sim::analysis::{frequency::bandwidth_hz, linear_models::black_box_1};
/// // p/(2 pi), the 4.775 Hz of the paper
/// assert!((bandwidth_hz(&black_box_1(30.0)).unwrap() - 4.7746).abs() < 1e-4);
/// ```
pub fn bandwidth_hz(system: &TransferFunction) -> Option<f64> {
    falls_to_hz(system, HALF_POWER_DB)
}

#[cfg(test)]
#[path = "frequency_tests.rs"]
mod tests;
