//! 64-bit quotients and products without the compiler's division routines: a Cortex-M4 divides 32
//! bits.

use core::num::NonZeroU64;

/// The low 128 bits of `dividend * 2^bits / divisor`, rounded down; the divisor is below 2^63.
///
/// Calculated bit by bit, with about 15 instructions per bit of the quotient and 90 bytes of code;
/// a 128-bit division takes 1.5 KB at each call.
///
/// ```
/// use core::num::NonZeroU64;
/// use model_core::excitation::quotient::quotient;
/// let three = NonZeroU64::new(3).unwrap();
/// assert_eq!((quotient(10, three, 0), quotient(1, three, 4)), (3, 5));
/// ```
#[inline(never)]
pub const fn quotient(dividend: u64, divisor: NonZeroU64, bits: u32) -> u128 {
    let (mut remainder, mut quotient): (u64, u128) = (0, 0);
    // Remaining bits of the dividend, the next bit at the top.
    let mut remaining = dividend;
    let mut step = 64 + bits;
    while step > 0 {
        step -= 1;
        // The remainder is below the divisor: twice the remainder plus one is below 2^64.
        remainder = remainder << 1 | remaining >> 63;
        remaining <<= 1;
        quotient <<= 1;
        if remainder >= divisor.get() {
            remainder -= divisor.get();
            quotient |= 1;
        }
    }
    quotient
}

/// `dividend / divisor`, rounded down; one instruction if both have 32 bits, which covers 59 hours
/// of ticks.
///
/// ```
/// use core::num::NonZeroU64;
/// use model_core::excitation::quotient::divide;
/// assert_eq!(divide(1 << 40, NonZeroU64::new(3).unwrap()), (1 << 40) / 3);
/// ```
#[inline]
pub const fn divide(dividend: u64, divisor: NonZeroU64) -> u64 {
    let short = divisor.get() as u32;
    if dividend >> 32 == 0
        && divisor.get() >> 32 == 0
        && let Some(quotient) = (dividend as u32).checked_div(short)
    {
        return quotient as u64;
    }
    quotient(dividend, divisor, 0) as u64
}

/// `a * b`, saturated; one function shared by all inputs on the board.
///
/// ```
/// use model_core::excitation::quotient::saturating_product;
/// assert_eq!(saturating_product(1 << 40, 1 << 23), 1 << 63);
/// assert_eq!(saturating_product(1 << 40, 1 << 24), u64::MAX);
/// ```
#[cfg_attr(target_os = "none", inline(never))]
pub const fn saturating_product(a: u64, b: u64) -> u64 {
    a.saturating_mul(b)
}

/// The remainder of [`divide`].
pub(super) const fn remainder(dividend: u64, divisor: NonZeroU64) -> u64 {
    dividend - divide(dividend, divisor) * divisor.get()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn it_is_the_division_of_128_bits(
            dividend: u64, divisor in 1..1u64 << 63, short in 1..1u64 << 16, bits in 0..=64u32
        ) {
            for divisor in [divisor, short] {
                let exact = (u128::from(dividend) << bits) / u128::from(divisor);
                let divisor = NonZeroU64::new(divisor).unwrap();
                prop_assert_eq!(quotient(dividend, divisor, bits), exact);
            }
        }

        #[test]
        fn whole_quotients_equal_native_division(
            dividend: u64, divisor in 1..1u64 << 63, drops in (0..64u32, 0..63u32)
        ) {
            let (dividend, divisor) = (dividend >> drops.0, (divisor >> drops.1).max(1));
            prop_assert_eq!(divide(dividend, NonZeroU64::new(divisor).unwrap()), dividend / divisor);
            prop_assert_eq!(remainder(dividend, NonZeroU64::new(divisor).unwrap()), dividend % divisor);
        }
    }

    #[test]
    fn fractions_of_a_turn_have_128_bits() {
        let seven = NonZeroU64::new(7).unwrap();
        // 2^128 = 7 * q + 4.
        assert_eq!(quotient(1, seven, 128), u128::MAX / 7);
    }
}
