//! The power of two in integer arithmetic, for the logarithmic chirp.

/// Terms of the power series after the constant; the first omitted term, (ln 2)^19/19!, is below
/// 2^-66.
const TERMS: usize = 18;

/// `(ln 2)^k / k!` for `k` from 1, in units of 2^-64.
const SERIES: [u64; TERMS] = series();

const fn series() -> [u64; TERMS] {
    const LN_2: u64 = 0xB172_17F7_D1CF_79AC;
    let mut series = [LN_2; TERMS];
    let mut k = 1;
    while k < TERMS {
        series[k] = product(series[k - 1], LN_2) / (k as u64 + 1);
        k += 1;
    }
    series
}

/// The product of two fractions in units of 2^-64, rounded down.
///
/// ```
/// use model_core::excitation::exp2::product;
/// assert_eq!(product(1 << 63, 1 << 63), 1 << 62);
/// ```
pub const fn product(a: u64, b: u64) -> u64 {
    ((a as u128 * b as u128) >> 64) as u64
}

/// `2^-y` in units of 2^-63, for `y` in units of 2^-96, with an error below 1e-18.
///
/// ```
/// use model_core::excitation::exp2::exp2_negative;
/// assert_eq!(exp2_negative(0), 1 << 63);
/// assert_eq!(exp2_negative(3 << 96), 1 << 60);
/// ```
pub const fn exp2_negative(y: u128) -> u64 {
    let fraction = (y >> 32) as u64;
    // The alternating series of e^-z. Each coefficient exceeds the next one times a fraction, so no
    // difference is negative.
    let mut sum = SERIES[TERMS - 1];
    let mut k = TERMS - 1;
    while k > 0 {
        k -= 1;
        sum = SERIES[k] - product(fraction, sum);
    }
    let mantissa = (1 << 63) - product(fraction, sum) / 2;
    // The integer part of y is below 2^32.
    match mantissa.checked_shr((y >> 96) as u32) {
        Some(power) => power,
        None => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_power_of_two_agrees_with_libm() {
        // The tolerance is libm's own error: one unit of 2^-53 and the rounding of its argument.
        let two_to_the_96 = libm::exp2(96.0);
        for i in 0..200_000 {
            let y = f64::from(i) / 10_000.0;
            let power = exp2_negative((y * two_to_the_96) as u128) as f64 / libm::exp2(63.0);
            let expected = libm::exp2(-y);
            assert!(
                (power - expected).abs() < 4e-16 * expected + 2e-19,
                "2^-{y}"
            );
        }
    }

    proptest! {
        #[test]
        fn the_power_of_two_decreases_monotonically(y: u128, more: u128) {
            prop_assert!(exp2_negative(y.saturating_add(more)) <= exp2_negative(y));
        }

        #[test]
        fn complementary_powers_multiply_to_one_half(half in 0_u128..1 << 96) {
            // 2^-h * 2^-(1-h) = 1/2.
            let h = u128::from(exp2_negative(half));
            let rest = u128::from(exp2_negative((1 << 96) - half));
            let octave = (h * rest) >> 63;
            prop_assert!(octave.abs_diff(1 << 62) < 12);
        }
    }
}
