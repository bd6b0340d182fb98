//! The law of a logarithmic chirp in integers.

use core::num::NonZeroU64;

use model_core::excitation::phase::Exponential;

/// Bits behind the point of a logarithm.
const LOG_BITS: u32 = 56;

/// ln 2 in units of 2^-64.
const LN_2: u128 = 12_786_308_645_202_655_660;

/// A sweep between two frequencies in 1e-3 Hz, both above zero. `None` where they are equal: the
/// linear law is the same then.
pub(super) fn sweep([start, end]: [u32; 2], duration_ticks: NonZeroU64) -> Option<Exponential> {
    let (slow, fast) = if start < end {
        (start, end)
    } else {
        (end, start)
    };
    // At most 17 octaves of 2^56.
    let octaves = binary_logarithm(fast, slow);
    let ln_ratio = (u128::from(octaves) * LN_2) >> 64;
    if ln_ratio == 0 {
        return None;
    }
    let duration = u128::from(duration_ticks.get());
    // B = f T / ln r: with f below 2^17 and T below 2^27 the turns f T are below 2^20, in units of
    // 2^-108 below 2^128. Over ln r, in units of 2^-56, they come out in units of 2^-52.
    let turns = (((u128::from(fast) * duration) << 80) / 20_000_000) << 28;
    let scale = (turns / ln_ratio.max(1)) << 12;
    let mut sweep = Exponential {
        scale,
        octaves_per_tick: (u128::from(octaves) << (96 - LOG_BITS)) / duration.max(1),
        duration_ticks: duration_ticks.get(),
        rising: start < end,
        offset: 0,
    };
    sweep.offset = sweep.at(0).wrapping_neg();
    Some(sweep)
}

/// `log2(fast/slow)` in units of 2^-56, bit by bit: squaring a number from 1 to 2 doubles its
/// logarithm.
fn binary_logarithm(fast: u32, slow: u32) -> u64 {
    let Some(slow) = NonZeroU64::new(u64::from(slow)) else {
        return 0;
    };
    // In units of 2^-32, below 2^49.
    let ratio = (u64::from(fast) << 32) / slow;
    let Some(whole) = ratio.checked_ilog2().and_then(|log| log.checked_sub(32)) else {
        return 0;
    };
    // In units of 2^-63, from 1 to 2: the ratio anew, with all its bits.
    let mut mantissa = (u128::from(fast) << (63 - whole)) / u128::from(slow.get()).max(1);
    let mut logarithm = u64::from(whole) << LOG_BITS;
    for bit in (0..LOG_BITS).rev() {
        mantissa = (mantissa * mantissa) >> 63;
        if mantissa >= 1 << 64 {
            mantissa >>= 1;
            logarithm |= 1 << bit;
        }
    }
    logarithm
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_are_those_of_floating_point() {
        extern crate std;
        for (fast, slow) in [
            (2, 1),
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
    fn equal_ends_are_no_logarithmic_sweep() {
        assert!(sweep([5, 5], NonZeroU64::MIN).is_none());
    }
}
