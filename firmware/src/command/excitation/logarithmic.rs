//! Phase law of a logarithmic chirp in integers.

use core::num::NonZeroU64;

use model_core::excitation::{
    exp2::product,
    phase::{Exponential, ratio},
};

use super::settings::PER_SECOND;

/// Fraction bits of a logarithm.
const LOG_BITS: u32 = 56;

/// ln 2 in units of 2^-64.
const LN_2: u64 = 12_786_308_645_202_655_660;

/// A sweep between two frequencies in 1e-3 Hz, both above zero and below 2^17, within less than
/// 2^27 ticks. `None` where they are equal: the linear law is the same then.
pub(super) fn sweep([start, end]: [u32; 2], duration_ticks: NonZeroU64) -> Option<Exponential> {
    let (slow, fast) = if start < end {
        (start, end)
    } else {
        (end, start)
    };
    // At most 17 octaves of 2^56, hence below 2^61, and so is the natural logarithm.
    let octaves = binary_logarithm(fast, slow);
    let ln_ratio = NonZeroU64::new(product(octaves, LN_2))?;
    // B = f T / ln r: the cycles f T are below 2^20 and fit in units of 2^-43. Divided by units of
    // 2^-56 and multiplied by 2^64 they are in units of 2^-51.
    let product = u64::from(fast).saturating_mul(duration_ticks.get());
    let turns = ratio(product, PER_SECOND, 43) as u64;
    let mut sweep = Exponential {
        scale: ratio(turns, ln_ratio, 64 + (64 - 51)),
        octaves_per_tick: ratio(octaves, duration_ticks, 96 - LOG_BITS),
        duration_ticks: duration_ticks.get(),
        rising: start < end,
        offset: 0,
    };
    sweep.offset = sweep.at(0).wrapping_neg();
    Some(sweep)
}

/// `log2(fast/slow)` in units of 2^-56, bit by bit: squaring a number from 1 to 2 doubles its
/// logarithm. Zero if `slow` is zero or above `fast`.
fn binary_logarithm(fast: u32, slow: u32) -> u64 {
    let Some(mut whole) = slow.leading_zeros().checked_sub(fast.leading_zeros()) else {
        return 0;
    };
    // Both are below 2^32, and so is `slow` times a power of two that leaves it at most `fast`.
    if slow << whole > fast {
        whole = whole.saturating_sub(1);
    }
    let Some(divisor) = NonZeroU64::new(u64::from(slow << whole)) else {
        return 0;
    };
    // In units of 2^-63, from 1 to 2.
    let mut mantissa = ratio(fast.into(), divisor, 63) as u64;
    let mut logarithm = u64::from(whole);
    for _ in 0..LOG_BITS {
        // From 1 to 4 in units of 2^-62: one bit less, restored below if the result is below 2.
        mantissa = product(mantissa, mantissa);
        logarithm <<= 1;
        if mantissa >> 63 == 1 {
            logarithm |= 1;
        } else {
            mantissa <<= 1;
        }
    }
    logarithm
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_match_floating_point() {
        extern crate std;
        for (fast, slow) in [
            (2_u32, 1_u32),
            (3, 1),
            (100_000, 1),
            (101, 100),
            (10_000, 100),
            (7, 7),
        ] {
            let exact = (f64::from(fast) / f64::from(slow)).log2();
            let ours = binary_logarithm(fast, slow) as f64 / (1u64 << LOG_BITS) as f64;
            assert!(
                (ours - exact).abs() < 1e-13,
                "{fast}/{slow}: {ours} {exact}"
            );
        }
    }

    #[test]
    fn equal_frequencies_have_no_logarithmic_sweep() {
        assert!(sweep([5, 5], NonZeroU64::MIN).is_none());
    }
}
