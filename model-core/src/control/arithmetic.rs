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
    #[inline]
    pub const fn times(self, signal: I32F32) -> I32F32 {
        let bits = signal.to_bits();
        let k = self.mantissa as i64;
        let (high, low) = ((bits >> 32) * k, (bits & 0xffff_ffff) * k);
        let shift = self.shift as u32;
        // The product is (high 2^32 + low) / 2^shift. |low| <= (2^32 - 1) 2^31 = 2^63 - 2^31 and
        // |high| <= 2^62.
        I32F32::from_bits(if shift > 32 {
            // What falls off `low` lies below the step of the result.
            let half = 1 << (shift - 33);
            (high + (low >> 32) + half) >> (shift - 32)
        } else {
            // At most 2^31, which `low` has room for. `high` goes to the left by what the product
            // is less a fraction, so it fits if the product does.
            let half = (1 << shift) >> 1;
            (high << (32 - shift)) + ((low + half) >> shift)
        })
    }
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
