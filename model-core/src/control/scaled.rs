//! Numbers of single precision into fixed point and back, in integers.
//!
//! A bus carries gains as IEEE 754 single precision; a Cortex-M4F has no instruction that takes
//! them to 64 bits. What comes out equals what the constructors in double precision make of the
//! same number.

use fixed::types::I32F32;

use super::{arithmetic::Coefficient, units::Quantity};
use crate::time::CONTROL_RATE_HZ;

/// A number `magnitude * 2^exponent` with its sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Scaled {
    magnitude: u64,
    exponent: i32,
    is_negative: bool,
}

/// The control rate, Hz.
const RATE: u64 = CONTROL_RATE_HZ as u64;

/// Bits of the control rate.
const RATE_BITS: u32 = 1 + RATE.ilog2();

/// The control period in units of 2^-47 s, to the nearest: at most 40 bits.
const PERIOD: u64 = ((1 << 47) + RATE / 2) / RATE;

const _: () = assert!(RATE >= 128, "the control period is below 2^-7 s");

impl Scaled {
    /// Exactly this number; infinities beyond any range of ours, NaN as zero.
    pub fn of_f32(value: f32) -> Self {
        let bits = value.to_bits();
        let (biased, fraction) = (bits >> 23 & 0xff, bits & 0x7f_ffff);
        let (magnitude, exponent) = match biased {
            0 => (fraction, -149),
            0xff if fraction != 0 => (0, -149),
            // From 1 to 255: an infinity is 2^128.
            _ => (fraction | 1 << 23, biased as i32 - 150),
        };
        Self {
            magnitude: u64::from(magnitude),
            exponent,
            is_negative: bits >> 31 == 1,
        }
    }

    /// Exactly this coefficient.
    pub fn of_coefficient(coefficient: Coefficient) -> Self {
        let (bits, exponent) = coefficient.parts();
        Self {
            magnitude: bits.unsigned_abs(),
            exponent,
            is_negative: bits < 0,
        }
    }

    /// Exactly this signal.
    pub fn of_signal(signal: impl Quantity) -> Self {
        let bits = signal.raw().to_bits();
        Self {
            magnitude: bits.unsigned_abs(),
            exponent: -32,
            is_negative: bits < 0,
        }
    }

    /// A number of single precision times the control period, off by 2^-40 of it at most.
    pub fn per_period(self) -> Self {
        Self {
            // 24 bits and 40.
            magnitude: self.magnitude * PERIOD,
            exponent: self.exponent - 47,
            ..self
        }
    }

    /// Times the control rate.
    pub fn per_second(self) -> Self {
        // A signal that is held within 2^18 has 50 bits. A coefficient has 31, below which there
        // are zeros.
        let drop = if self.magnitude >> (64 - RATE_BITS) == 0 {
            0
        } else {
            RATE_BITS
        };
        Self {
            magnitude: (self.magnitude >> drop) * RATE,
            exponent: self.exponent + drop as i32,
            ..self
        }
    }

    /// The nearest coefficient; saturates.
    pub fn coefficient(self) -> Coefficient {
        // The greatest shift that leaves 31 bits, or 62.
        let bits = 64 - self.magnitude.leading_zeros() as i32;
        let widest = (31 - bits - self.exponent).min(62);
        let mut shift = widest.max(0);
        let mut mantissa = rounded(self.magnitude, self.exponent + shift);
        if mantissa > i32::MAX as u64 && shift > 0 {
            shift -= 1;
            mantissa = rounded(self.magnitude, self.exponent + shift);
        }
        let mantissa = mantissa.min(i32::MAX as u64) as i32;
        Coefficient::from_parts(
            if self.is_negative {
                -mantissa
            } else {
                mantissa
            },
            shift as u8,
        )
    }

    /// The nearest signal; saturates.
    pub fn signal<Q: Quantity>(self) -> Q {
        let bits = rounded(self.magnitude, self.exponent + 32).min(i64::MAX as u64) as i64;
        Q::from_raw(I32F32::from_bits(if self.is_negative {
            -bits
        } else {
            bits
        }))
    }

    /// The nearest number of single precision; beyond them infinite, below the normal ones zero.
    pub fn f32(self) -> f32 {
        let bits = 64 - self.magnitude.leading_zeros() as i32;
        let mut exponent = self.exponent + bits - 24;
        let mut mantissa = rounded(self.magnitude, 24 - bits);
        if mantissa == 1 << 24 {
            (mantissa, exponent) = (1 << 23, exponent + 1);
        }
        let sign = u32::from(self.is_negative) << 31;
        f32::from_bits(
            sign | match exponent + 150 {
                _ if mantissa == 0 => 0,
                ..=0 => 0,
                255.. => 0xff << 23,
                biased => (biased as u32) << 23 | (mantissa as u32 & 0x7f_ffff),
            },
        )
    }
}

/// `value * 2^shift` to the nearest integer, halves away from zero; saturates.
fn rounded(value: u64, shift: i32) -> u64 {
    match shift {
        _ if value == 0 => 0,
        0.. if shift as u32 > value.leading_zeros() => u64::MAX,
        0.. => value << shift,
        -63..0 => (value >> -shift) + (value >> (-shift - 1) & 1),
        -64 => value >> 63,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        control::units::{Percent, percent},
        time::CONTROL_PERIOD_S,
    };
    use proptest::prelude::*;

    fn any_f32() -> impl Strategy<Value = f32> {
        any::<u32>().prop_map(f32::from_bits)
    }

    proptest! {
        #[test]
        fn coefficients_and_signals_are_those_of_double_precision(value in any_f32()) {
            // The least integers have no opposite here.
            prop_assume!(value >= -2_147_483_520.0 || value.is_nan());
            let wide = f64::from(value);
            prop_assert_eq!(Scaled::of_f32(value).coefficient(), Coefficient::new(wide));
            let signal: Percent = Scaled::of_f32(value).signal();
            prop_assert_eq!(signal, percent(wide));
        }

        #[test]
        fn per_control_period_they_are_off_by_a_unit_at_most(value in 0f32..1e6) {
            let wide = f64::from(value) * CONTROL_PERIOD_S;
            let ours = Scaled::of_f32(value).per_period().coefficient().exactly();
            let expected = Coefficient::new(wide).exactly();
            // One of 31 bits, or of 62 behind the point.
            prop_assert!(ours.abs_diff(expected) <= (expected >> 30).unsigned_abs().max(1));
        }

        #[test]
        fn single_precision_comes_back_unchanged(value in any_f32().prop_filter("normal", |v| v.is_normal())) {
            let there = Scaled::of_f32(value);
            prop_assert_eq!(there.f32().to_bits(), value.to_bits());
            // 31 bits, less what lies below 2^-62.
            if value.abs() > 1e-9 && value.abs() < 2e9 {
                let through = Scaled::of_coefficient(there.coefficient());
                prop_assert_eq!(through.f32().to_bits(), value.to_bits());
                if value.abs() > 1e-7 && value.abs() < 1e9 {
                    let through = Scaled::of_coefficient(there.per_period().coefficient());
                    prop_assert_eq!(through.per_second().f32().to_bits(), value.to_bits());
                }
            }
        }
    }

    #[test]
    fn a_product_that_rounds_up_to_32_bits_is_normalised() {
        // The period is rounded down: 250 of them are below one by less than half a unit.
        let rate = CONTROL_RATE_HZ as f32;
        let one = Scaled::of_f32(rate).per_period().coefficient();
        assert_eq!(one, Coefficient::new(1.0));
    }

    #[test]
    fn a_coefficient_whose_31_bits_are_all_ones_comes_back_unchanged() {
        for shift in 0..=62 {
            let there = Coefficient::from_parts(i32::MAX, shift);
            assert_eq!(Scaled::of_coefficient(there).coefficient(), there);
        }
    }

    #[test]
    fn the_last_bits_are_rounded() {
        // 25 bits to 24.
        let odd = Scaled::of_signal(Percent::from_int(33_554_431));
        assert_eq!(odd.f32(), 33_554_432.0);
        // A half of the least step: the highest of 64 bits behind the point.
        let half = Scaled {
            magnitude: 1 << 63,
            exponent: -96,
            is_negative: false,
        };
        assert_eq!(half.signal::<Percent>(), Percent::from_bits(1));
        let less = Scaled {
            magnitude: (1 << 63) - 1,
            ..half
        };
        assert_eq!(less.signal::<Percent>(), Percent::ZERO);
    }

    #[test]
    fn zero_has_no_sign_and_numbers_beyond_single_precision_are_zero_or_infinite() {
        assert_eq!(Scaled::of_signal(Percent::ZERO).f32().to_bits(), 0);
        let zero = Scaled::of_coefficient(Coefficient::default());
        assert_eq!(zero.f32().to_bits(), 0);
        assert_eq!(Scaled::of_f32(f32::from_bits(1)).f32().to_bits(), 0);
        assert_eq!(
            Scaled::of_f32(-f32::MAX).per_second().f32(),
            f32::NEG_INFINITY
        );
    }

    #[test]
    fn what_no_number_of_single_precision_is_ends_at_their_ends() {
        assert_eq!(Scaled::of_f32(f32::NAN).signal::<Percent>(), Percent::ZERO);
        assert_eq!(
            Scaled::of_f32(f32::INFINITY).coefficient(),
            Coefficient::new(f64::INFINITY)
        );
        assert_eq!(Scaled::of_f32(f32::INFINITY).f32(), f32::INFINITY);
        assert_eq!(Scaled::of_signal(Percent::MIN).f32(), -2_147_483_648.0);
    }
}
