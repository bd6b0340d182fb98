//! Times in control periods, and quantities in thousandths.

use model_core::{
    control::units::{Angle, Quantity, Rate},
    time::{CONTROL_RATE_HZ, UPDATE_PERIODS_PER_CONTROL_PERIOD},
};

/// Length of one control period, ms.
pub const CONTROL_PERIOD_MS: i32 = 1000 / CONTROL_RATE_HZ as i32;

const _: () = assert!(
    1000 % CONTROL_RATE_HZ == 0,
    "a control period is a whole number of milliseconds"
);

/// The update periods of a control period in which the calls of the CANopen device start: at the
/// first edge after the control step, and so that the second call ends before the last update
/// period, also if that is short.
pub const COMMUNICATION_PERIODS: [u32; 2] = {
    let eighth = UPDATE_PERIODS_PER_CONTROL_PERIOD / 8;
    let first = if eighth == 0 { 1 } else { eighth };
    [first, UPDATE_PERIODS_PER_CONTROL_PERIOD / 2 - eighth]
};

/// Whole control periods in a time, at least one; saturates at 65,535.
///
/// ```
/// use firmware::timing::{CONTROL_PERIOD_MS, periods};
/// assert_eq!([0, 1, 11, 100].map(|n| periods(n * CONTROL_PERIOD_MS)), [1, 1, 11, 100]);
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

/// The angle nearest to this number of thousandths of a degree, beyond 44,000 deg a step of 2^-32
/// beside it.
///
/// ```
/// use firmware::timing::angle_of_mdeg;
/// use model_core::control::units::angle;
/// assert_eq!(angle_of_mdeg(-12_500), angle(-12.5));
/// ```
pub const fn angle_of_mdeg(angle_mdeg: i32) -> Angle {
    Angle::from_bits(bits_of_thousandths(angle_mdeg))
}

/// The rate nearest to this number of thousandths of a degree per second, beyond 44,000 deg/s a
/// step of 2^-32 beside it.
///
/// ```
/// use firmware::timing::rate_of_mdeg_s;
/// use model_core::control::units::rate;
/// assert_eq!(rate_of_mdeg_s(350_001), rate(350.001));
/// ```
pub const fn rate_of_mdeg_s(rate_mdeg_s: i32) -> Rate {
    Rate::from_bits(bits_of_thousandths(rate_mdeg_s))
}

/// Steps of 2^-32 nearest to this number of thousandths, beyond 44,000,000 at most one beside it.
#[inline(never)]
const fn bits_of_thousandths(thousandths: i32) -> i64 {
    // 2^32/1000 = 4,294,967.296, whose fraction is in steps of 2^-32. It is off by 0.4 of them: of
    // a result by 4e-5 up to 360,000 thousandths, by 0.2 at the ends of the range.
    const WHOLE: i64 = (1 << 32) / 1000;
    const FRACTION: i64 = ((((1 << 32) % 1000) << 32) + 500) / 1000;
    let thousandths = thousandths as i64;
    thousandths * WHOLE + ((thousandths * FRACTION + (1 << 31)) >> 32)
}

/// A quantity in thousandths of its unit, rounded to the nearest; saturates.
///
/// ```
/// use firmware::timing::{angle_of_mdeg, thousandths};
/// assert_eq!(thousandths(angle_of_mdeg(-179_999)), -179_999);
/// ```
pub fn thousandths(value: impl Quantity) -> i32 {
    thousandths_of_bits(value.raw().to_bits())
}

/// One function for all quantities: on the board it exists once.
#[inline(never)]
const fn thousandths_of_bits(bits: i64) -> i32 {
    // 2^21 units: times 2^32 and 1000 that is below 2^63, and 2,097,151,000 is an i32.
    const END: i32 = 2_097_151;
    let whole = (bits >> 32) as i32;
    if whole >= END {
        END * 1000
    } else if whole < -END {
        -END * 1000
    } else {
        ((bits * 1000 + (1 << 31)) >> 32) as i32
    }
}

/// The angle that a rate travels in one control period.
///
/// ```
/// use firmware::timing::angle_per_period;
/// use model_core::{control::units::Angle, time::CONTROL_RATE_HZ};
/// assert_eq!(angle_per_period(CONTROL_RATE_HZ as i32), Angle::ONE);
/// ```
pub const fn angle_per_period(rate_deg_s: i32) -> Angle {
    Angle::from_bits(bits_per_period(rate_deg_s))
}

/// The change of a rate in one control period.
///
/// ```
/// use firmware::timing::rate_per_period;
/// use model_core::{control::units::Rate, time::CONTROL_RATE_HZ};
/// assert_eq!(rate_per_period(2 * CONTROL_RATE_HZ as i32), Rate::from_int(2));
/// ```
pub const fn rate_per_period(acceleration_deg_s2: i32) -> Rate {
    Rate::from_bits(bits_per_period(acceleration_deg_s2))
}

/// Steps of 2^-32 of this number of units per second in a control period.
const fn bits_per_period(per_second: i32) -> i64 {
    const PERIODS_PER_SECOND: i32 = CONTROL_RATE_HZ as i32;
    // To the nearest, off by half a step in 2^32/1000 at the most. Times a rest below the rate it
    // is at most 2^32.
    const STEPS: i64 = ((1_i64 << 32) + PERIODS_PER_SECOND as i64 / 2) / PERIODS_PER_SECOND as i64;
    let whole = (per_second / PERIODS_PER_SECOND) as i64;
    let rest = (per_second % PERIODS_PER_SECOND) as i64;
    (whole << 32) + rest * STEPS
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn every_command_in_thousandths_is_within_a_step_of_the_exact_angle_and_comes_back(
            mdeg in -2_097_151_000i32..2_097_151_000
        ) {
            let angle = angle_of_mdeg(mdeg);
            let exact = i128::from(mdeg) << 32;
            let apart = (i128::from(angle.to_bits()) * 1000 - exact).abs();
            // Half a step, and the error of the fraction, in thousandths of a step.
            prop_assert!(apart <= 501 + ((i128::from(mdeg.abs()) * 384) >> 32));
            prop_assert_eq!(thousandths(angle), mdeg);
        }

        #[test]
        fn no_angle_overflows(bits: i64, mdeg: i32) {
            let _ = thousandths(Angle::from_bits(bits));
            let _ = angle_of_mdeg(mdeg);
        }
    }
}
