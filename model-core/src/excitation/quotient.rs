//! Quotients and products of 64 bits, small and without a routine of the compiler's: a Cortex-M4 divides 32 bits.

use core::num::NonZeroU64;

/// `dividend * 2^bits / divisor`, rounded down, of which the low 128 bits are kept; the divisor is
/// below 2^63.
///
/// Bit by bit: some 15 instructions for each bit of the quotient, and 90 bytes of code where a
/// division of 128 bits takes 1.5 KB at each place.
///
/// ```
/// use core::num::NonZeroU64;
/// use model_core::excitation::quotient::quotient;
/// let three = NonZeroU64::new(3).unwrap();
/// assert_eq!((quotient(10, three, 0), quotient(1, three, 4)), (3, 5));
/// ```
#[inline(never)]
pub const fn quotient(dividend: u64, divisor: NonZeroU64, bits: u32) -> u128 {
    let (mut rest, mut quotient): (u64, u128) = (0, 0);
    // What is still to be fetched, the next bit at the top.
    let mut left = dividend;
    let mut step = 64 + bits;
    while step > 0 {
        step -= 1;
        // The rest is below the divisor: twice that and one is below 2^64.
        rest = rest << 1 | left >> 63;
        left <<= 1;
        quotient <<= 1;
        if rest >= divisor.get() {
            rest -= divisor.get();
            quotient |= 1;
        }
    }
    quotient
}

/// `dividend / divisor`, rounded down: in one instruction where both have 32 bits, which 59 hours of
/// ticks do.
///
/// ```
/// use core::num::NonZeroU64;
/// use model_core::excitation::quotient::whole;
/// assert_eq!(whole(1 << 40, NonZeroU64::new(3).unwrap()), (1 << 40) / 3);
/// ```
#[inline]
pub const fn whole(dividend: u64, divisor: NonZeroU64) -> u64 {
    let short = divisor.get() as u32;
    if dividend >> 32 == 0
        && divisor.get() >> 32 == 0
        && let Some(quotient) = (dividend as u32).checked_div(short)
    {
        return quotient as u64;
    }
    quotient(dividend, divisor, 0) as u64
}

/// `a * b`; where that has more than 64 bits the greatest number. On the board all share this one.
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

/// What [`whole`] leaves of the dividend.
pub(super) const fn rest(dividend: u64, divisor: NonZeroU64) -> u64 {
    dividend - whole(dividend, divisor) * divisor.get()
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
        fn whole_quotients_are_those_of_the_processor(
            dividend: u64, divisor in 1..1u64 << 63, drops in (0..64u32, 0..63u32)
        ) {
            let (dividend, divisor) = (dividend >> drops.0, (divisor >> drops.1).max(1));
            prop_assert_eq!(whole(dividend, NonZeroU64::new(divisor).unwrap()), dividend / divisor);
            prop_assert_eq!(rest(dividend, NonZeroU64::new(divisor).unwrap()), dividend % divisor);
        }
    }

    #[test]
    fn fractions_of_a_turn_have_128_bits() {
        let seven = NonZeroU64::new(7).unwrap();
        // 2^128 = 7 * q + 4.
        assert_eq!(quotient(1, seven, 128), u128::MAX / 7);
    }
}
