//! The integer time base and the rates of the loops: the only source of all of them.
//!
//! One tick is 50 us. Tick `i` is the instant `i * 50 us` and the half-open interval that starts
//! there. Every event time is a whole number of ticks, so that nothing drifts and every target
//! agrees on the order of events.
//!
//! The rates are those of the paper, section II.A. A build with the environment variable
//! `ACTUATOR_RATES_1_KHZ` has the second set, which `tests/rates/check.sh` tests. It is not a
//! feature, so that no dependency can switch it on for others.
//!
//! | | paper | second set |
//! |---|---|---|
//! | control step | 250 Hz | 1 kHz |
//! | update of the compare values | 1 kHz | 4 kHz |
//! | PWM | 1 kHz | 20 kHz |
//! | current | 250 Hz | 1 kHz |
//! | back-EMF, in a coast window | 250 Hz | 250 Hz |
//!
//! An update period is the time between two edges at which compare values take effect: one PWM
//! period of the paper, five of the second set. There the inductance of the winding smooths the
//! current and no human ear detects the PWM. The coast window takes 5 % of the drive in both sets;
//! in every control period it would take 20 % at 1 kHz.

/// Whether this build has the second set of rates.
const SECOND_SET: bool = option_env!("ACTUATOR_RATES_1_KHZ").is_some();

/// Rate of the control step, Hz.
pub const CONTROL_RATE_HZ: u32 = if SECOND_SET { 1_000 } else { 250 };

/// Rate at which the compare values of the PWM are updated, Hz.
pub const UPDATE_RATE_HZ: u32 = if SECOND_SET { 4_000 } else { 1_000 };

/// Rate of the PWM, Hz.
pub const PWM_RATE_HZ: u32 = if SECOND_SET { 20_000 } else { 1_000 };

/// Rate of the coast windows, in which the back-EMF is sampled, Hz.
pub const WINDOW_RATE_HZ: u32 = 250;

/// Ticks in one second.
pub const TICKS_PER_SECOND: u64 = 20_000;

/// Length of one tick, s.
pub const TICK_S: f64 = 1.0 / TICKS_PER_SECOND as f64;

/// PWM periods in one update period.
pub const PWM_PERIODS_PER_UPDATE: u32 =
    whole_quotient(PWM_RATE_HZ as u64, UPDATE_RATE_HZ as u64) as u32;

/// Ticks in one update period.
pub const UPDATE_PERIOD_TICKS: u64 = whole_quotient(TICKS_PER_SECOND, UPDATE_RATE_HZ as u64);

/// Length of one update period, ns.
pub const UPDATE_PERIOD_NS: u64 = whole_quotient(1_000_000_000, UPDATE_RATE_HZ as u64);

/// Ticks in one control period.
pub const CONTROL_PERIOD_TICKS: u64 = whole_quotient(TICKS_PER_SECOND, CONTROL_RATE_HZ as u64);

/// Length of one control period, us.
pub const CONTROL_PERIOD_US: u32 = whole_quotient(1_000_000, CONTROL_RATE_HZ as u64) as u32;

/// Length of one control period, s.
pub const CONTROL_PERIOD_S: f64 = 1.0 / CONTROL_RATE_HZ as f64;

/// Update periods in one control period.
pub const UPDATE_PERIODS_PER_CONTROL_PERIOD: u32 =
    whole_quotient(UPDATE_RATE_HZ as u64, CONTROL_RATE_HZ as u64) as u32;

/// Control periods from one coast window to the next.
pub const CONTROL_PERIODS_PER_WINDOW: u32 =
    whole_quotient(CONTROL_RATE_HZ as u64, WINDOW_RATE_HZ as u64) as u32;

/// `a / b`, which must be an integer: checked at compile time.
const fn whole_quotient(a: u64, b: u64) -> u64 {
    assert!(
        a.is_multiple_of(b),
        "a period is not a whole number of its unit"
    );
    a / b
}

/// The tick nearest to `seconds`; negative times and NaN give tick 0.
///
/// ```
/// assert_eq!(model_core::time::ticks(0.0175), 350);
/// assert_eq!(model_core::time::ticks(-1.0), 0);
/// ```
pub fn ticks(seconds: f64) -> u64 {
    let exact = seconds * TICKS_PER_SECOND as f64;
    // `as` saturates: a time beyond u64 becomes u64::MAX, NaN and negative times become 0. Faster
    // than `libm::round`, which has no instruction for it on most targets.
    let whole = exact as u64;
    whole.saturating_add(u64::from(exact - whole as f64 >= 0.5))
}

/// The instant of a tick, s.
///
/// ```
/// assert_eq!(model_core::time::seconds(350), 0.0175);
/// ```
pub fn seconds(tick: u64) -> f64 {
    tick as f64 / TICKS_PER_SECOND as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_nearest_tick_is_that_of_rounding_half_away_from_zero(
            seconds in prop_oneof![any::<f64>(), -1.0..1e4, 0.0..1e-3], half in 0_u32..1 << 30
        ) {
            let half = (f64::from(half) + 0.5) / TICKS_PER_SECOND as f64;
            for seconds in [seconds, half, half.next_up(), half.next_down(), f64::NAN] {
                let rounded = libm::round(seconds * TICKS_PER_SECOND as f64) as u64;
                prop_assert_eq!(ticks(seconds), rounded);
            }
        }
    }
}
