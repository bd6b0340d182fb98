//! The integer time base.
//!
//! One tick is 50 us. Tick `i` is the instant `i * 50 us` and the half-open interval that starts
//! there. Every event time is a whole number of ticks, so that nothing drifts and every target
//! agrees on what happens when.

/// Ticks in one second.
pub const TICKS_PER_SECOND: u64 = 20_000;

/// Length of one tick, s.
pub const TICK_S: f64 = 50e-6;

/// Ticks in one PWM period: 1 ms (paper, section II.A).
pub const PWM_PERIOD_TICKS: u64 = 20;

/// Ticks in one control period: 4 ms, 250 Hz (paper, section II.A).
pub const CONTROL_PERIOD_TICKS: u64 = 80;

/// Length of one control period, s.
pub const CONTROL_PERIOD_S: f64 = 4e-3;

/// Ticks in one host period: 20 ms, 50 Hz (paper, section II.A).
pub const HOST_PERIOD_TICKS: u64 = 400;

/// The tick nearest to `seconds`; negative times and NaN give tick 0.
///
/// ```
/// assert_eq!(model_core::time::ticks(0.0175), 350);
/// assert_eq!(model_core::time::ticks(-1.0), 0);
/// ```
pub fn ticks(seconds: f64) -> u64 {
    // `as` saturates: a time beyond u64 becomes u64::MAX, NaN becomes 0.
    libm::round(seconds * TICKS_PER_SECOND as f64) as u64
}

/// The instant of a tick, s.
///
/// ```
/// assert_eq!(model_core::time::seconds(350), 0.0175);
/// ```
pub fn seconds(tick: u64) -> f64 {
    tick as f64 / TICKS_PER_SECOND as f64
}
