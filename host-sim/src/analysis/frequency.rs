//! Bode plots and bandwidths of transfer functions.

pub use identification::frequency::{decibel, logarithmic_grid, unwrap_deg};

use super::transfer_function::TransferFunction;

/// Gain below which a system is said to let nothing through: half the power, -3.0103 dB.
pub const HALF_POWER_DB: f64 = -3.010_299_956_639_812;

// Ends of every search, Hz. A servo answers between 0.1 and 100 Hz: three decades to spare below,
// two above.
const LOWEST_HZ: f64 = 1e-4;
const HIGHEST_HZ: f64 = 1e4;
// 1.2 % from point to point. A loop with 8 periods of delay, the most that is accepted, turns by
// less than 20 degrees in one step at the Nyquist frequency: no crossing hides between two points.
const SEARCH_POINTS_PER_DECADE: usize = 200;

/// A frequency response, one value a frequency.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Response {
    /// Frequencies, Hz.
    pub frequency_hz: Vec<f64>,
    /// Gains, dB.
    pub gain_db: Vec<f64>,
    /// Phases, deg, without jumps by whole turns.
    pub phase_deg: Vec<f64>,
}

impl Response {
    /// The response of `system` at ascending frequencies.
    ///
    /// The first phase, but for the transport delay, is taken within half a turn of zero, and the
    /// following ones within half a turn of their neighbour: begin low.
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

/// The grid on which crossings of `system` are searched, to just below the Nyquist frequency: there
/// every response is real, and rounding would decide the sign of its imaginary part.
pub(crate) fn search_grid(system: &TransferFunction) -> Vec<f64> {
    let to_hz = HIGHEST_HZ.min(system.nyquist_hz() * (1.0 - 1e-6));
    logarithmic_grid(LOWEST_HZ, to_hz, SEARCH_POINTS_PER_DECADE)
}

/// Where `f` changes its sign along the grid, each place found to the last digit by bisection.
pub(crate) fn sign_changes(grid: &[f64], f: impl Fn(f64) -> f64) -> impl Iterator<Item = f64> {
    grid.windows(2).filter_map(move |ends| {
        let positive = f(ends[0]) > 0.0;
        let changes = (f(ends[1]) > 0.0) != positive;
        changes.then(|| bisect(ends[0], ends[1], |x| (f(x) > 0.0) == positive))
    })
}

/// The last point from `low` on at which `holds`, taken to hold at `low`, and not to at `high`.
pub(crate) fn bisect(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    // Each turn halves the interval: after 60 it has no number inside.
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

/// The first frequency, Hz, at which the gain of `system` lies `fall_db` (negative) beside its
/// steady gain; `None` where it never does, or where there is no steady gain.
pub fn falls_to_hz(system: &TransferFunction, fall_db: f64) -> Option<f64> {
    let level_db = decibel(system.steady_gain()) + fall_db;
    if !level_db.is_finite() {
        return None;
    }
    let above = |f| decibel(system.rational_at(f).norm()) - level_db;
    sign_changes(&search_grid(system), above).next()
}

/// The bandwidth, Hz: where the power has fallen to a half.
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
