//! The one multiplication of the control path: a signal by a coefficient.

use fixed::types::I32F32;

use super::units::round;

/// A coefficient: 31 bits and a sign, as far to the left as the value allows.
///
/// Coefficients have 32 bits, signals 64: their product is two 32 x 32 -> 64 bit multiplications,
/// which a Cortex-M4 does in one instruction each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Coefficient {
    mantissa: i32,
    /// The mantissa is the value times 2^shift; 62 at the most.
    shift: u8,
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
        Self {
            mantissa: round(value * (1u64 << shift) as f64) as i32,
            shift,
        }
    }

    /// Mantissa and shift: the value is `mantissa * 2^-shift`.
    pub(super) const fn parts(self) -> (i32, u8) {
        (self.mantissa, self.shift)
    }

    /// The coefficient of these parts; the shift is 62 at the most.
    pub(super) const fn from_parts(mantissa: i32, shift: u8) -> Self {
        Self { mantissa, shift }
    }

    /// The product with a signal, rounded to the nearest step of the signal.
    ///
    /// The caller shows that the product lies within +-2^31.
    pub const fn times(self, signal: I32F32) -> I32F32 {
        let bits = signal.to_bits();
        let k = self.mantissa as i64;
        // The product is 2^32 upper + lowest, in units of 2^-shift of a step of the signal:
        // |(2^32 - 1) k| <= 2^63 - 2^31, and |bits >> 32| times |k| are 2^62 at the most.
        let low = (bits as u32 as i64) * k;
        let upper = (bits >> 32) * k + (low >> 32);
        let lowest = low as u32;
        // By words: a Cortex-M4 shifts no more than 32 bits at once.
        I32F32::from_bits(if self.shift >= 32 {
            // What falls off `lowest` lies below the step of the result.
            let shift = self.shift as u32 - 32;
            let half =
                ((1 << shift) >> 1) as i64 + if shift == 0 { (lowest >> 31) as i64 } else { 0 };
            let [low, high] = words(upper + half);
            joined(right(high, low, shift), ((high as i32) >> shift) as u32)
        } else {
            let shift = self.shift as u32;
            let (lowest, carry) = lowest.overflowing_add((1 << shift) >> 1);
            let [low, high] = words(upper + carry as i64);
            // What goes off on the left is the sign, if the product fits.
            joined(right(low, lowest, shift), right(high, low, shift))
        })
    }
}

/// The words of a number, the lower one first.
#[inline]
const fn words(bits: i64) -> [u32; 2] {
    [bits as u32, (bits >> 32) as u32]
}

/// What they are the words of.
#[inline]
const fn joined(low: u32, high: u32) -> i64 {
    ((high as u64) << 32 | low as u64) as i64
}

/// The lower word of two that go to the right by 0 to 31 bits.
#[inline]
const fn right(high: u32, low: u32, shift: u32) -> u32 {
    low >> shift | high << 1 << (31 - shift)
}

#[cfg(test)]
impl Coefficient {
    /// The coefficient in units of 2^-62.
    pub(crate) fn exactly(self) -> i128 {
        i128::from(self.mantissa) << (62 - self.shift)
    }
}

const fn magnitude(value: f64) -> f64 {
    if value < 0.0 { -value } else { value }
}
