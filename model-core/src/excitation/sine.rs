//! The sine in integer arithmetic.
//!
//! A phase is a `u64` fraction of a turn, so it wraps exactly at a full turn. The sine is an
//! [`I2F30`], which represents both plus and minus one, with an error below 1.5e-9. The `cossin` of
//! the crate `idsp` is faster, but its error of 1e-5 is too large for an amplitude of 20 deg.

use super::{product, saturated};
use crate::control::units::Angle;
use fixed::types::I2F30;

/// A quarter of a turn.
pub(super) const QUARTER: u64 = 1 << 62;

/// Terms of the power series; the first omitted term, (pi/2)^17/17!, is 6e-12.
const TERMS: usize = 8;

/// Magnitudes of the coefficients of `sin(pi/2 x) / x` as a series in `x^2`, in units of 2^-32.
const SERIES: [u64; TERMS] = series();

const fn series() -> [u64; TERMS] {
    // In units of 2^-62, where pi/2 fits: 1.58 * 2^62 < 2^63.
    const HALF_PI: u128 = (core::f64::consts::FRAC_PI_2 * QUARTER as f64) as u128;
    const SQUARE: u128 = (HALF_PI * HALF_PI) >> 62;
    let mut series = [0; TERMS];
    let mut term = HALF_PI;
    let mut k = 0;
    while k < TERMS {
        series[k] = ((term + (1 << 29)) >> 30) as u64;
        let order = 2 * k as u128 + 2;
        term = ((term * SQUARE) >> 62) / (order * (order + 1));
        k += 1;
    }
    series
}

/// The sine of a phase, which is a fraction of a turn in units of 2^-64.
///
/// ```
/// use model_core::excitation::sine::sine;
/// assert_eq!(sine(0), 0.0);
/// assert_eq!(sine(1 << 62), 1.0);
/// assert_eq!(sine(3 << 62), -1.0);
/// assert!((sine(u64::MAX / 12).to_num::<f64>() - 0.5).abs() < 2e-9);
/// ```
pub const fn sine(phase: u64) -> I2F30 {
    let within = phase % QUARTER;
    let folded = if phase & QUARTER == 0 {
        within
    } else {
        QUARTER - within
    };
    // At most 2^62, hence x at most 2^31, one quarter of a turn, and its square at most 2^32.
    let x = (folded + (1 << 30)) >> 31;
    let square = (x * x) >> 30;
    let mut sum = SERIES[TERMS - 1];
    let mut k = TERMS - 1;
    while k > 0 {
        k -= 1;
        // All coefficients except the first are below 2^32: the product fits. Each exceeds the next
        // one: the difference is not negative.
        sum = SERIES[k] - ((square * sum) >> 32);
    }
    // At most 2^31 * 1.58 * 2^32 < 2^64.
    let magnitude = ((x * sum + (1 << 32)) >> 33) as i32;
    I2F30::from_bits(if phase >> 63 == 0 {
        magnitude
    } else {
        -magnitude
    })
}

/// `amplitude * sum`, rounded and saturated, where `sum` is a sine or a sum of sines in units of
/// 2^-30.
///
/// ```
/// use model_core::{control::units::Angle, excitation::sine::scaled};
/// assert_eq!(scaled(Angle::from_int(20), 1 << 29), Angle::from_int(10));
/// ```
pub const fn scaled(amplitude: Angle, sum: i64) -> Angle {
    // 2^63 * 2^63 plus half a unit is below 2^127.
    saturated((product(amplitude.to_bits(), sum) + (1 << 29)) >> 30)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;
    use proptest::prelude::*;

    fn true_sine(phase: u64) -> f64 {
        libm::sin(phase as f64 / 18_446_744_073_709_551_616.0 * TAU)
    }

    #[test]
    fn the_error_of_the_sine_is_below_1_5e_9() {
        // A prime stride visits every quadrant at a million points with varying low bits.
        let worst = (0..1_000_003_u64)
            .map(|i| i.wrapping_mul(u64::MAX / 1_000_003))
            .map(|phase| (sine(phase).to_num::<f64>() - true_sine(phase)).abs())
            .fold(0.0, f64::max);
        assert!(worst < 1.5e-9, "{worst}");
    }

    #[test]
    fn the_sine_is_exact_at_quarter_turns_and_never_exceeds_one() {
        for (quarter, value) in [0, 1, 0, -1].into_iter().enumerate() {
            assert_eq!(sine((quarter as u64) << 62), value);
        }
        for near in 0..100_000_u64 {
            for step in [near, near << 31] {
                assert!(sine(QUARTER - step) <= I2F30::ONE);
                assert!(sine(QUARTER - step) > 0.9999);
            }
        }
    }

    proptest! {
        #[test]
        fn the_sine_is_odd_and_symmetric_about_quarter_turns(phase: u64) {
            prop_assert_eq!(sine(phase.wrapping_neg()), -sine(phase));
            prop_assert_eq!(sine((1_u64 << 63).wrapping_sub(phase)), sine(phase));
        }

        #[test]
        fn a_scaled_sum_saturates_and_is_rounded(amplitude: i64, sum: i64) {
            let exact = amplitude as f64 * sum as f64 / f64::from(1 << 30);
            let limited = exact.max(i64::MIN as f64).min(i64::MAX as f64);
            let bits = scaled(Angle::from_bits(amplitude), sum).to_bits() as f64;
            // Half an LSB, and the rounding of `f64`.
            prop_assert!((bits - limited).abs() <= 0.5 + limited.abs() * 1e-15);
        }
    }
}
