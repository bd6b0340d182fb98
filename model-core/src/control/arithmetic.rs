//! The one multiplication of the control path: a signal by a coefficient.

use fixed::types::I32F32;

use super::units::round;

/// A coefficient: 31 bits and a sign, as far to the left as the value allows.
///
/// It is `whole + upper 2^-32 + lower 2^-64`. Each of these digits has a sign of its own, and so have
/// those that [`Coefficient::times`] splits a signal into: a Cortex-M4 multiplies two such digits and adds the
/// product to what it has in one instruction, and nothing is left to be shifted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Coefficient {
    /// Zero where `lower` is none.
    whole: i32,
    upper: i32,
    /// Zero where the magnitude is a half or more.
    lower: i32,
}

impl Coefficient {
    /// The coefficient nearest to `value`, off by 2^-31 of it at most where it is 2^-32 or more.
    /// Saturates at +-2^31; NaN gives zero.
    pub const fn new(value: f64) -> Self {
        let mut shift = 62;
        // 2^31 - 1 is odd: half a step more would round to what no i32 holds.
        while shift > 0 && magnitude(value) * (1u64 << shift) as f64 >= i32::MAX as f64 - 0.5 {
            shift -= 1;
        }
        Self::from_parts(round(value * (1u64 << shift) as f64) as i32, shift)
    }

    /// The coefficient `mantissa * 2^-shift`; the shift is 62 at the most, and the greatest that the mantissa leaves.
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
        // Digits are 2^31 at the most: this is below 2^31, and with another sign bit it is half a step more.
        let lowest = (product(low, self.lower) >> 32) as u32 ^ 1 << 31;
        // Where `lower` is not zero, `upper` is 2^30 at the most: the sums are below 2^63.
        let below = lowest as i64 + product(low, self.upper) + product(high, self.lower);
        // What leaves 64 bits between these sums comes back, for the product does not leave them.
        let bits = (below >> 32).wrapping_add(product(high, self.upper));
        let bits = bits.wrapping_add(product(low, self.whole));
        let above = ((bits >> 32) as i32).wrapping_add(high.wrapping_mul(self.whole));
        I32F32::from_bits((above as i64) << 32 | (bits as u32) as i64)
    }
}

/// The digits of a number in base 2^32, the lower one first, each with a sign.
#[inline(always)]
const fn digits(bits: i64) -> [i32; 2] {
    // What the lower one is below zero, the upper one makes up for.
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
        // The last two bits of 64 are none's.
        (i128::from(bits) << (64 + exponent)) >> 2
    }
}

const fn magnitude(value: f64) -> f64 {
    if value < 0.0 { -value } else { value }
}
