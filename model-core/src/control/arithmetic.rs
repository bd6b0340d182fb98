//! The one multiplication of the control path: a signal by a coefficient.

use core::marker::PhantomData;

use fixed::types::I32F32;

use super::units::{Quantity, round};

/// A coefficient that makes a quantity of type `To` of one of type `From`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct Gain<From, To> {
    coefficient: Coefficient,
    quantities: PhantomData<(From, To)>,
}

impl<From: Quantity, To: Quantity> Gain<From, To> {
    /// The gain nearest to `value`, which is in units of `To` per unit of `From`.
    pub const fn new(value: f64) -> Self {
        Self::of(Coefficient::new(value))
    }

    /// The gain of this coefficient.
    pub const fn of(coefficient: Coefficient) -> Self {
        Self {
            coefficient,
            quantities: PhantomData,
        }
    }

    /// Its coefficient.
    pub const fn coefficient(self) -> Coefficient {
        self.coefficient
    }

    /// The product, rounded to the nearest step; bounds as for [`Coefficient::times`].
    #[inline(always)]
    pub fn times(self, quantity: From) -> To {
        To::from_raw(self.coefficient.times(quantity.raw()))
    }
}

/// A coefficient: 31 bits and a sign, as far to the left as the value allows.
///
/// The value is `whole + upper 2^-32 + lower 2^-64`. Each digit has a sign of its own, and so have
/// the digits of the signal in [`Coefficient::times`]: a Cortex-M4 multiplies two signed digits and
/// accumulates the product in one instruction, without a shift.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Coefficient {
    /// Zero where `lower` is not zero.
    whole: i32,
    upper: i32,
    /// Zero where the magnitude is a half or more.
    lower: i32,
}

impl Coefficient {
    /// The coefficient nearest to `value`; the relative error is at most 2^-31 from 2^-32 on.
    /// Saturates at +-2^31; NaN gives zero.
    pub const fn new(value: f64) -> Self {
        let mut shift = 62;
        // 2^31 - 1 is odd: half a step more would round beyond the range of i32.
        while shift > 0 && magnitude(value) * (1u64 << shift) as f64 >= i32::MAX as f64 - 0.5 {
            shift -= 1;
        }
        Self::from_parts(round(value * (1u64 << shift) as f64) as i32, shift)
    }

    /// The coefficient `mantissa * 2^-shift`, normalised: `shift` is the greatest possible, at most
    /// 62.
    pub(super) const fn from_parts(mantissa: i32, shift: u8) -> Self {
        let bits = (mantissa as i64) << (32 - shift % 32);
        let [low, high] = digits(bits);
        if shift < 32 {
            Self {
                whole: high,
                upper: low,
                lower: 0,
            }
        } else {
            Self {
                whole: 0,
                upper: high,
                lower: low,
            }
        }
    }

    /// Bits and exponent: the value is `bits * 2^exponent`.
    pub(super) const fn parts(self) -> (i64, i32) {
        if self.lower == 0 {
            (((self.whole as i64) << 32) + self.upper as i64, -32)
        } else {
            (((self.upper as i64) << 32) + self.lower as i64, -64)
        }
    }

    /// The product with a signal, rounded to the nearest step of the signal.
    ///
    /// The caller shows that signal and product lie within +-2^30.
    #[inline(always)]
    pub const fn times(self, signal: I32F32) -> I32F32 {
        let [low, high] = digits(signal.to_bits());
        // Digits are at most 2^31, so this is below 2^31; inverting its sign bit adds half a step.
        let lowest = (product(low, self.lower) >> 32) as u32 ^ 1 << 31;
        // Where `lower` is not zero, `upper` is 2^30 at the most: the sums are below 2^63.
        let below = lowest as i64 + product(low, self.upper) + product(high, self.lower);
        // Intermediate sums may wrap: the product itself fits 64 bits.
        let bits = (below >> 32).wrapping_add(product(high, self.upper));
        let bits = bits.wrapping_add(product(low, self.whole));
        let above = ((bits >> 32) as i32).wrapping_add(high.wrapping_mul(self.whole));
        I32F32::from_bits((above as i64) << 32 | (bits as u32) as i64)
    }
}

/// The digits of a number in base 2^32, the lower one first, each with a sign.
#[inline(always)]
const fn digits(bits: i64) -> [i32; 2] {
    // The upper digit compensates for a negative lower one.
    let low = bits as i32;
    [low, (bits.wrapping_sub(low as i64) >> 32) as i32]
}

/// The whole product.
#[inline(always)]
const fn product(a: i32, b: i32) -> i64 {
    a as i64 * b as i64
}

#[cfg(test)]
impl Coefficient {
    /// The coefficient in units of 2^-62.
    pub(crate) fn exactly(self) -> i128 {
        let (bits, exponent) = self.parts();
        // No coefficient has bits below 2^-62.
        (i128::from(bits) << (64 + exponent)) >> 2
    }
}

const fn magnitude(value: f64) -> f64 {
    if value < 0.0 { -value } else { value }
}
