//! What the control path computes with: a signal times a coefficient, and a limit.

use fixed::types::I32F32;

use super::units::round;

/// A coefficient with `FRACTION` fractional bits.
///
/// Coefficients have 32 bits, signals 64: their product is two 32 x 32 -> 64 bit multiplications,
/// which a Cortex-M4 does in one instruction each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Coefficient<const FRACTION: i32>(i32);

impl<const FRACTION: i32> Coefficient<FRACTION> {
    /// The coefficient nearest to `value`; saturates, NaN gives zero.
    ///
    /// ```
    /// use model_core::control::arithmetic::Coefficient;
    /// use fixed::types::I32F32;
    ///
    /// let half = Coefficient::<30>::new(0.5);
    /// assert_eq!(half.times(I32F32::from_num(-3)), I32F32::from_num(-1.5));
    /// ```
    pub const fn new(value: f64) -> Self {
        Self(round(value * (1u64 << FRACTION) as f64) as i32)
    }

    /// The product with a signal, rounded to the nearest step of the signal.
    ///
    /// The caller shows that the product lies within +-2^31.
    #[inline]
    pub const fn times(self, signal: I32F32) -> I32F32 {
        let bits = signal.to_bits();
        let k = self.0 as i64;
        let high = bits >> 32;
        let low = bits & 0xffff_ffff;
        // |low k| <= (2^32 - 1) 2^31 = 2^63 - 2^31, and half of the last place is at most 2^30:
        // the sum stays below 2^63.
        let half = 1 << (FRACTION - 1);
        // high k 2^(32 - FRACTION) is the product less a fraction, so it fits if the product does.
        I32F32::from_bits(((high * k) << (32 - FRACTION)) + ((low * k + half) >> FRACTION))
    }

    /// The integer that is the coefficient times 2^`FRACTION`.
    pub const fn to_bits(self) -> i32 {
        self.0
    }
}

/// `value` held between `low` and `high`; unlike `clamp` it cannot panic.
#[inline]
pub(crate) fn within<T: PartialOrd>(value: T, low: T, high: T) -> T {
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}
