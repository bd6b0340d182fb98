//! The control period as a number: everything here is counted in it.

use model_core::control::units::{Angle, held};

/// Length of one control period, ms.
pub const CONTROL_PERIOD_MS: i32 = 4;

/// Whole control periods in a time, one at the least; times up to 262 s.
///
/// ```
/// use firmware::timing::periods;
/// assert_eq!([0, 4, 11, 100].map(periods), [1, 1, 2, 25]);
/// ```
pub const fn periods(time_ms: i32) -> u16 {
    let periods = time_ms / CONTROL_PERIOD_MS;
    if periods < 1 {
        1
    } else if periods > u16::MAX as i32 {
        u16::MAX
    } else {
        periods as u16
    }
}

/// The angle nearest to so many thousandths of a degree.
///
/// ```
/// use firmware::timing::angle_of_mdeg;
/// assert_eq!(angle_of_mdeg(-12_500), -12.5);
/// ```
#[inline(never)]
pub const fn angle_of_mdeg(angle_mdeg: i32) -> Angle {
    // 2^52/1000 to the nearest: times at most 999 it is below 2^52, off by 2^9, which the shift by
    // 20 drops to 5e-4 of a step.
    const STEPS_PER_MDEG: i64 = 4_503_599_627_370;
    let whole = (angle_mdeg / 1000) as i64;
    let rest = (angle_mdeg % 1000) as i64;
    Angle::from_bits((whole << 32) + ((rest * STEPS_PER_MDEG + (1 << 19)) >> 20))
}

/// An angle or a rate in thousandths, rounded to the nearest; ends at those of `i32`.
///
/// ```
/// use firmware::timing::{angle_of_mdeg, thousandths};
/// assert_eq!(thousandths(angle_of_mdeg(-179_999)), -179_999);
/// ```
#[inline(never)]
pub const fn thousandths(value: Angle) -> i32 {
    // Held within 2^21 units: times 2^32 and 1000 that is below 2^63, and 2,097,151,000 is an i32.
    const END: Angle = Angle::const_from_int(2_097_151);
    let units = held(value, END).to_bits();
    ((units * 1000 + (1 << 31)) >> 32) as i32
}

/// How far a rate goes in one control period.
///
/// ```
/// use firmware::timing::angle_per_period;
/// assert_eq!(angle_per_period(250), 1);
/// ```
pub const fn angle_per_period(rate_deg_s: i32) -> Angle {
    // 2^32/250 to the nearest, off by 1e-8 of it. Below 2^25: times 249 within 2^33.
    const STEPS_PER_DEG_S: i64 = 17_179_869;
    const PERIODS_PER_SECOND: i32 = 250;
    let whole = (rate_deg_s / PERIODS_PER_SECOND) as i64;
    let rest = (rate_deg_s % PERIODS_PER_SECOND) as i64;
    Angle::from_bits((whole << 32) + rest * STEPS_PER_DEG_S)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn every_command_in_thousandths_is_the_nearest_angle_and_comes_back(
            mdeg in -2_097_151_000i32..2_097_151_000
        ) {
            let angle = angle_of_mdeg(mdeg);
            let exact = i128::from(mdeg) << 32;
            let apart = (i128::from(angle.to_bits()) * 1000 - exact).abs();
            // Half a step, and 5e-4 of one.
            prop_assert!(apart <= 501);
            prop_assert_eq!(thousandths(angle), mdeg);
        }

        #[test]
        fn no_angle_overflows(bits: i64, mdeg: i32) {
            let _ = thousandths(Angle::from_bits(bits));
            let _ = angle_of_mdeg(mdeg);
        }
    }
}
