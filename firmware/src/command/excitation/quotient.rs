//! The one long division of the excitations' settings.

use core::num::NonZeroU64;

/// `dividend * 2^64 / divisor`, rounded down; the divisor is below 2^63.
///
/// Bit by bit: some 500 instructions, and 60 bytes of code where a division of 128 bits takes 1.5 KB
/// at each place.
#[inline(never)]
pub(super) fn quotient(dividend: u64, divisor: NonZeroU64) -> u128 {
    let mut rest = dividend % divisor;
    let mut fraction: u64 = 0;
    for _ in 0..64 {
        // The rest is below the divisor: twice that is below 2^64.
        rest <<= 1;
        fraction <<= 1;
        if rest >= divisor.get() {
            rest -= divisor.get();
            fraction |= 1;
        }
    }
    u128::from(dividend / divisor) << 64 | u128::from(fraction)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn it_is_the_division_of_128_bits(dividend: u64, divisor in 1..1u64 << 63) {
            let divisor = NonZeroU64::new(divisor).unwrap();
            let exact = (u128::from(dividend) << 64) / u128::from(divisor.get());
            prop_assert_eq!(quotient(dividend, divisor), exact);
        }
    }
}
