//! The one multiplication of the control path: a signal by a coefficient.

use core::marker::PhantomData;

use fixed::types::I32F32;

use super::units::{Quantity, round};

/// A coefficient that makes a quantity of type `To` of one of type `From`; `VECTOR` as for
/// [`Coefficient`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = ""))]
pub struct Gain<From, To, const VECTOR: bool = false> {
    coefficient: Coefficient<VECTOR>,
    quantities: PhantomData<(From, To)>,
}

impl<From: Quantity, To: Quantity> Gain<From, To> {
    /// The gain nearest to `value`, which is in units of `To` per unit of `From`.
    pub const fn new(value: f64) -> Self {
        Self::of(Coefficient::new(value))
    }
}

impl<From: Quantity, To: Quantity, const VECTOR: bool> Gain<From, To, VECTOR> {
    /// The gain of this coefficient.
    #[inline(always)]
    pub const fn of(coefficient: Coefficient<VECTOR>) -> Self {
        Self {
            coefficient,
            quantities: PhantomData,
        }
    }

    /// Its coefficient.
    pub const fn coefficient(self) -> Coefficient<VECTOR> {
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
/// accumulates the product in one instruction, without a shift. So does a vector unit, which has no
/// product of 64 bits: `VECTOR` coefficients are multiplied by digits on every processor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Coefficient<const VECTOR: bool = false> {
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
}

impl<const VECTOR: bool> Coefficient<VECTOR> {
    /// Its digits of weight 1, 2^-32 and 2^-64.
    pub(super) const fn digits(self) -> [i32; 3] {
        [self.whole, self.upper, self.lower]
    }

    /// The coefficient of the digits of another.
    #[inline(always)]
    pub(super) const fn of_digits([whole, upper, lower]: [i32; 3]) -> Self {
        Self {
            whole,
            upper,
            lower,
        }
    }

    /// The product with a signal, rounded to the nearest step of the signal.
    ///
    /// The caller shows that signal and product lie within +-2^30.
    #[inline(always)]
    pub const fn times(self, signal: I32F32) -> I32F32 {
        I32F32::from_bits(if cfg!(target_pointer_width = "64") && !VECTOR {
            self.times_word(signal.to_bits())
        } else {
            self.times_digits(signal.to_bits())
        })
    }

    /// The product by the multiplications of a Cortex-M4.
    #[inline(always)]
    const fn times_digits(self, signal: i64) -> i64 {
        let [low, high] = digits(signal);
        // Digits are at most 2^31, so this is below 2^31; inverting its sign bit adds half a step.
        let lowest = (product(low, self.lower) >> 32) as u32 ^ 1 << 31;
        // Where `lower` is not zero, `upper` is 2^30 at the most: the sums are below 2^63.
        let below = lowest as i64 + product(low, self.upper) + product(high, self.lower);
        // Intermediate sums may wrap: the product itself fits 64 bits.
        let bits = (below >> 32).wrapping_add(product(high, self.upper));
        let bits = bits.wrapping_add(product(low, self.whole));
        let above = ((bits >> 32) as i32).wrapping_add(high.wrapping_mul(self.whole));
        (above as i64) << 32 | (bits as u32) as i64
    }

    /// The same product on a processor that multiplies 64 bits by 64 bits.
    #[inline(always)]
    const fn times_word(self, signal: i64) -> i64 {
        // The digits below the point, in units of 2^-64: they fit, as they were made of 64 bits.
        let fraction = ((self.upper as i64) << 32).wrapping_add(self.lower as i64);
        let exact = signal as i128 * fraction as i128;
        // The whole digit adds no bits below the point, so rounding concerns the fraction alone:
        // half a step carries where the highest bit below the point is set.
        let rounded = ((exact >> 64) as i64).wrapping_add((exact as u64 >> 63) as i64);
        // Parts may wrap: the product itself fits 64 bits.
        rounded.wrapping_add(signal.wrapping_mul(self.whole as i64))
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn words_and_digits_give_the_same_product(
            magnitude in 0..=i32::MAX, is_negative: bool, shift in 0_u8..=62,
            signal: i64, narrower in 2_u32..62
        ) {
            // Normalised: below the greatest shift the mantissa has 31 bits.
            let magnitude = if shift < 62 { magnitude | 1 << 30 } else { magnitude };
            let mantissa = if is_negative { -magnitude } else { magnitude };
            let coefficient = Coefficient::from_parts(mantissa, shift);
            let signal = signal >> narrower;
            let exact = (i128::from(signal) * i128::from(mantissa)) >> shift;
            prop_assume!(exact.unsigned_abs() < 1 << 62);
            prop_assert_eq!(coefficient.times_word(signal), coefficient.times_digits(signal));
        }
    }
}
