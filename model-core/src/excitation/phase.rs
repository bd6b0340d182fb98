//! Phases by integer tick, exact modulo one turn.
//!
//! A phase is a fraction of a turn in units of 2^-64. Whole turns overflow out of the integer, so
//! wrapping is exact and no phase drifts with time.

use super::exp2::exp2_negative;
use crate::time::TICK_S;
use core::{f64::consts::LN_2, num::NonZeroU64};

const TWO_TO_THE_64: f64 = 18_446_744_073_709_551_616.0;
const TWO_TO_THE_96: f64 = (1_u128 << 96) as f64;
const TWO_TO_THE_128: f64 = TWO_TO_THE_64 * TWO_TO_THE_64;

/// `numerator * 2^bits / denominator`, rounded down, modulo 2^128; at most 128 bits.
///
/// The shifted numerator has up to 192 bits: the fraction is divided in two steps of 64 bits.
///
/// ```
/// use core::num::NonZeroU64;
/// use model_core::excitation::phase::ratio;
/// let three = NonZeroU64::new(3).unwrap();
/// assert_eq!((ratio(10, three, 0), ratio(1, three, 4)), (3, 5));
/// ```
// Not inlined: its divisions of 128 bits are 1 KiB of a board's program, in each place.
#[inline(never)]
pub const fn ratio(numerator: u64, denominator: NonZeroU64, bits: u32) -> u128 {
    let denominator = denominator.get() as u128;
    let numerator = numerator as u128;
    // Remainders are below the denominator, hence below 2^64.
    let upper = (numerator % denominator) << 64;
    let lower = (upper % denominator) << 64;
    // In units of 2^-128.
    let fraction = ((upper / denominator) << 64) | (lower / denominator);
    let whole = numerator / denominator;
    match bits {
        0 => whole,
        128.. => fraction,
        _ => (whole << bits) | (fraction >> (128 - bits)),
    }
}

/// A phase that is a quadratic function of time: a linear frequency sweep or a constant frequency.
///
/// `phase(i) = per_tick * i + per_tick_squared * i^2`. With 128 bits the error of a coefficient is
/// at most 2^-129 turn, and that of the phase after 1,000 s (2e7 ticks) 1e-24 turn. The dominant
/// error is that of the constructor's `f64`: 2e-16 of the number of turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Quadratic {
    /// In units of 2^-128 turn per tick; negative ones as two's complement.
    pub per_tick: u128,
    /// In units of 2^-128 turn per tick squared; negative ones as two's complement.
    pub per_tick_squared: u128,
}

impl Quadratic {
    /// A sweep from one frequency to another within `duration_ticks`, which continues after it.
    ///
    /// ```
    /// use model_core::excitation::phase::Quadratic;
    /// let sweep = Quadratic::sweep(1.0, 3.0, 20_000);
    /// // t + t^2 after a third of a second.
    /// assert!((sweep.at(6_667) as f64 / 2f64.powi(64) - 4.0 / 9.0).abs() < 1e-4);
    /// ```
    pub const fn sweep(start_hz: f64, end_hz: f64, duration_ticks: u64) -> Self {
        // t^2 (f1 - f0)/(2 T), all times in ticks.
        let growth = (end_hz - start_hz) * TICK_S / (2.0 * duration_ticks as f64);
        Self {
            per_tick: turns(start_hz * TICK_S),
            per_tick_squared: turns(growth),
        }
    }

    /// A constant frequency.
    ///
    /// ```
    /// use model_core::excitation::phase::Quadratic;
    /// assert!(Quadratic::steady(1.0).at(5_000).abs_diff(1 << 62) < 1 << 12);
    /// ```
    pub const fn steady(frequency_hz: f64) -> Self {
        Self::sweep(frequency_hz, frequency_hz, 1)
    }

    /// The phase at a tick.
    pub const fn at(&self, tick: u64) -> u64 {
        let tick = tick as u128;
        let slope = self
            .per_tick
            .wrapping_add(self.per_tick_squared.wrapping_mul(tick));
        (slope.wrapping_mul(tick) >> 64) as u64
    }
}

/// A fraction of a turn in units of 2^-128, at most half a turn in either direction; NaN is 0.
const fn turns(fraction: f64) -> u128 {
    (fraction * TWO_TO_THE_128) as i128 as u128
}

/// A phase whose frequency is an exponential function of time: a logarithmic sweep.
///
/// With `B = f T / ln r` for the faster end `f` and the ratio `r` of the ends, the phase at `y`
/// octaves below the faster end is `B 2^-y` plus a constant, or `-B 2^-y` where the frequency
/// falls. Relative to the faster end the power never exceeds one: its error of 1e-18 is an error of
/// `B * 1e-18` turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Exponential {
    /// `B` in units of 2^-64 turn.
    pub scale: u128,
    /// Change of the frequency in octaves per tick, in units of 2^-96.
    pub octaves_per_tick: u128,
    /// Duration of the sweep.
    pub duration_ticks: u64,
    /// Whether the frequency rises.
    pub rising: bool,
    /// Constant for which the sweep starts at phase zero, in units of 2^-64 turn.
    pub offset: u64,
}

impl Exponential {
    /// A sweep from one frequency to another, both above zero, within `duration_ticks`. `None` if
    /// the two differ by less than one part in a million: use [`Quadratic`], which then differs by
    /// 1e-13 of the number of turns.
    ///
    /// ```
    /// use model_core::excitation::phase::Exponential;
    /// let sweep = Exponential::sweep(0.5, 8.0, 60_000).unwrap();
    /// // 3 s * 7.5 Hz / ln 16 = 8.1151 turns.
    /// assert!((sweep.at(60_000) as f64 / 2f64.powi(64) - 0.1151).abs() < 1e-4);
    /// assert!(Exponential::sweep(1.0, 1.0, 60_000).is_none());
    /// ```
    pub fn sweep(start_hz: f64, end_hz: f64, duration_ticks: u64) -> Option<Self> {
        let rising = end_hz > start_hz;
        let fast_hz = if rising { end_hz } else { start_hz };
        let octaves = libm::fabs(libm::log2(end_hz / start_hz));
        let duration = duration_ticks as f64;
        let scale = fast_hz * TICK_S * duration / (octaves * LN_2);
        let mut sweep = Self {
            scale: (scale * TWO_TO_THE_64) as u128,
            octaves_per_tick: (octaves / duration * TWO_TO_THE_96) as u128,
            duration_ticks,
            rising,
            offset: 0,
        };
        sweep.offset = sweep.at(0).wrapping_neg();
        // This form rejects NaN.
        (octaves * LN_2 > 1e-6).then_some(sweep)
    }

    /// The phase at a tick of the sweep.
    pub const fn at(&self, tick: u64) -> u64 {
        let turns = if self.rising {
            self.turns(self.duration_ticks.saturating_sub(tick))
        } else {
            self.turns(tick).wrapping_neg()
        };
        turns.wrapping_add(self.offset)
    }

    /// `B 2^-y` modulo one turn, `ticks` away from the faster end.
    const fn turns(&self, ticks: u64) -> u64 {
        let power = exp2_negative(self.octaves_per_tick.wrapping_mul(ticks as u128));
        let whole = (self.scale >> 64) as u64;
        let fraction = self.scale as u64;
        // Units of 2^-63 times whole turns: the bit that the shift discards is a whole turn.
        let of_whole = whole.wrapping_mul(power) << 1;
        of_whole.wrapping_add(((fraction as u128 * power as u128) >> 63) as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::TICKS_PER_SECOND;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_ratio_is_the_division_of_128_bits(
            numerator: u64, long in 1..1u64 << 63, short in 1..1u64 << 16, bits in 0..=64u32
        ) {
            for denominator in [long, short] {
                let exact = (u128::from(numerator) << bits) / u128::from(denominator);
                let denominator = NonZeroU64::new(denominator).unwrap();
                prop_assert_eq!(ratio(numerator, denominator, bits), exact);
            }
        }

        #[test]
        fn a_longer_ratio_is_rounded_down_to_a_shorter_one(
            numerator: u64, denominator in 1..u64::MAX, bits in 1..128u32
        ) {
            let denominator = NonZeroU64::new(denominator).unwrap();
            let (long, short) = (ratio(numerator, denominator, 128), ratio(numerator, denominator, bits));
            prop_assert_eq!(long >> (128 - bits), short & (u128::MAX >> (128 - bits)));
        }
    }

    #[test]
    fn a_fraction_of_a_turn_has_128_bits() {
        let seven = NonZeroU64::new(7).unwrap();
        // 2^128 = 7 * q + 4.
        assert_eq!(ratio(1, seven, 128), u128::MAX / 7);
    }

    /// Distance of a phase from a number of turns, in turns.
    fn distance(phase: u64, turns: f64) -> f64 {
        let difference = phase as f64 / TWO_TO_THE_64 - turns;
        (difference - libm::round(difference)).abs()
    }

    #[test]
    fn a_linear_sweep_of_1000_s_keeps_its_phase_within_1e_9_turn() {
        let ticks = 1000 * TICKS_PER_SECOND;
        for (start, end) in [(0.1, 10.0), (10.0, 0.1), (0.0, 100.0)] {
            let sweep = Quadratic::sweep(start, end, ticks);
            for tick in (0..=ticks).step_by(9_973) {
                let t = tick as f64 / TICKS_PER_SECOND as f64;
                let turns = (start + (end - start) / 2000.0 * t) * t;
                // 1e-11 of it is the error of the f64 formula: 50,000 turns of 2^-53.
                assert!(
                    distance(sweep.at(tick), turns) < 1e-9,
                    "{start} {end} {tick}"
                );
            }
        }
    }

    #[test]
    fn a_constant_frequency_does_not_drift() {
        // A frequency of 2^-k turn per tick is exact, and so is its phase at any time.
        let steady = Quadratic::steady(20_000.0 / 1024.0);
        for turns in [1, 631_152_000_000, u64::MAX / 1024] {
            assert_eq!(steady.at(turns * 1024), 0);
            assert_eq!(steady.at(turns * 1024 + 256), 1 << 62);
        }
    }

    #[test]
    fn a_logarithmic_sweep_follows_its_closed_form() {
        for (start, end, duration) in [(0.1, 10.0, 20.0), (10.0, 0.1, 20.0), (1e-3, 100.0, 1000.0)]
        {
            let ticks = crate::time::ticks(duration);
            let sweep = Exponential::sweep(start, end, ticks).unwrap();
            let log_ratio = libm::log(end / start);
            for tick in (0..=ticks).step_by(997) {
                let t = crate::time::seconds(tick);
                let grown = libm::expm1(log_ratio * t / duration);
                let turns = start * duration / log_ratio * grown;
                assert!(
                    distance(sweep.at(tick), turns) < 1e-9,
                    "{start} {end} {tick}"
                );
            }
        }
    }

    #[test]
    fn both_laws_agree_for_nearly_equal_frequencies() {
        let ticks = 100 * TICKS_PER_SECOND;
        let end = 10.0 * (1.0 + 1.1e-6);
        let exponential = Exponential::sweep(10.0, end, ticks).unwrap();
        let quadratic = Quadratic::sweep(10.0, end, ticks);
        assert_eq!(Exponential::sweep(10.0, 10.000_005, ticks), None);
        for tick in (0..=ticks).step_by(1009) {
            let apart = exponential.at(tick).wrapping_sub(quadratic.at(tick)) as i64;
            // B is 1e9 turns here: 1e9 * 1e-18, and 2e-16 of 1,000 turns.
            assert!((apart as f64 / TWO_TO_THE_64).abs() < 1e-8, "{tick}");
        }
    }
}
