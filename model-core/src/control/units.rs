//! The quantities of the control path: angle, rate and share of the supply, each a type of its own.
//!
//! All of them are fixed point with 32 fractional bits. An encoder count is 45/512 deg, so every
//! measured angle is exact in 9 fractional bits, and so is every difference quotient
//! `counts * 45/512 deg / 4 ms`. Commands use the other 23 bits: where a loop limit-cycles around
//! one encoder count, a command that is off by 1e-5 deg moves the instant at which the count
//! changes, and from there on the trace differs.
//!
//! Quantities of the same type add and subtract. Only a `Gain` makes one
//! of another, for example a rate of an angle.

use core::hint::cold_path;

use fixed::types::I32F32;

/// A fixed-point quantity of the control path.
pub trait Quantity: Copy + PartialOrd {
    /// The quantity of this raw value, in units of 2^-32.
    fn from_raw(raw: I32F32) -> Self;

    /// The raw value.
    fn raw(self) -> I32F32;
}

macro_rules! quantity {
    ($(#[$doc:meta])+ $Name:ident, $(#[$constructor_doc:meta])+ $constructor:ident) => {
        $(#[$doc])+
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[cfg_attr(feature = "serde", serde(transparent))]
        pub struct $Name(I32F32);

        $(#[$constructor_doc])+
        pub const fn $constructor(value: f64) -> $Name {
            $Name(nearest(value))
        }

        impl $Name {
            /// Zero.
            pub const ZERO: Self = Self(I32F32::ZERO);
            /// One unit.
            pub const ONE: Self = Self(I32F32::ONE);
            /// The least value.
            pub const MIN: Self = Self(I32F32::MIN);
            /// The greatest value.
            pub const MAX: Self = Self(I32F32::MAX);

            /// The value of so many steps of 2^-32.
            pub const fn from_bits(bits: i64) -> Self {
                Self(I32F32::from_bits(bits))
            }

            /// Steps of 2^-32.
            pub const fn to_bits(self) -> i64 {
                self.0.to_bits()
            }

            /// A whole number of units.
            pub const fn from_int(value: i32) -> Self {
                Self(I32F32::from_bits((value as i64) << 32))
            }

            /// The value in whole units, rounded down.
            pub const fn to_int(self) -> i32 {
                (self.0.to_bits() >> 32) as i32
            }

            /// The value in floating point, to 53 bits.
            pub const fn to_f64(self) -> f64 {
                self.0.to_bits() as f64 / STEPS_PER_UNIT
            }

            /// The magnitude; saturates.
            pub const fn abs(self) -> Self {
                Self(self.0.saturating_abs())
            }

            /// The value limited to `-limit..=limit`; `limit` is not negative.
            ///
            /// ```
            /// use model_core::control::units::angle;
            /// assert_eq!(angle(-3.0).limited(angle(2.0)), angle(-2.0));
            /// assert_eq!(angle(1.0).limited(angle(2.0)), angle(1.0));
            /// ```
            pub const fn limited(self, limit: Self) -> Self {
                Self(limited_raw(self.0, limit.0))
            }

            /// The value, or `greatest` if that is less.
            pub const fn at_most(self, greatest: Self) -> Self {
                if self.to_bits() < greatest.to_bits() {
                    self
                } else {
                    greatest
                }
            }

            /// The opposite; saturates.
            pub const fn saturating_neg(self) -> Self {
                Self(self.0.saturating_neg())
            }

            /// The sum; saturates.
            pub const fn saturating_add(self, other: Self) -> Self {
                Self(self.0.saturating_add(other.0))
            }

            /// The difference; saturates.
            pub const fn saturating_sub(self, other: Self) -> Self {
                Self(self.0.saturating_sub(other.0))
            }
        }

        impl Quantity for $Name {
            #[inline(always)]
            fn from_raw(raw: I32F32) -> Self {
                Self(raw)
            }

            #[inline(always)]
            fn raw(self) -> I32F32 {
                self.0
            }
        }

        impl core::ops::Add for $Name {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                Self(self.0 + other.0)
            }
        }

        impl core::ops::Sub for $Name {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                Self(self.0 - other.0)
            }
        }

        impl core::ops::Neg for $Name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }

        impl core::ops::AddAssign for $Name {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                self.0 += other.0;
            }
        }

        impl core::ops::SubAssign for $Name {
            #[inline(always)]
            fn sub_assign(&mut self, other: Self) {
                self.0 -= other.0;
            }
        }

        impl core::fmt::Display for $Name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                core::fmt::Display::fmt(&self.0, f)
            }
        }
    };
}

quantity! {
    /// An angle, deg, in steps of 2.3e-10 deg.
    Angle,
    /// The angle nearest to `degrees`; saturates, NaN gives zero.
    ///
    /// ```
    /// use model_core::control::units::{Angle, angle};
    /// assert_eq!(angle(45.0 / 512.0), Angle::from_bits(45 << 23));
    /// assert_eq!(angle(1e10), Angle::MAX);
    /// assert_eq!(angle(f64::NAN), Angle::ZERO);
    /// ```
    angle
}

quantity! {
    /// An angular rate, deg/s, in steps of 2.3e-10 deg/s.
    Rate,
    /// The rate nearest to `degrees_per_second`; saturates, NaN gives zero.
    ///
    /// ```
    /// use model_core::control::units::{Rate, rate};
    /// assert_eq!(rate(-350.0), Rate::from_int(-350));
    /// ```
    rate
}

quantity! {
    /// A share of the supply voltage, %, in steps of 2.3e-10 %.
    Percent,
    /// The share nearest to `value`; saturates, NaN gives zero.
    ///
    /// ```
    /// use model_core::control::units::{Percent, percent};
    /// assert_eq!(percent(100.0), Percent::from_int(100));
    /// assert_eq!(percent(f64::INFINITY), Percent::MAX);
    /// ```
    percent
}

/// The control step takes angles within +-32,768 deg, 91 turns, and limits all others to that.
pub const ANGLE_END: Angle = Angle::from_int(1 << 15);

/// Steps in one unit.
const STEPS_PER_UNIT: f64 = 4_294_967_296.0;

/// The number in steps of 2^-32 that lies nearest to `value`; saturates, NaN gives zero.
const fn nearest(value: f64) -> I32F32 {
    // The cast saturates and takes NaN to 0.
    I32F32::from_bits(round(value * STEPS_PER_UNIT) as i64)
}

/// One function for all quantities: on the board it exists once.
#[cfg_attr(target_os = "none", inline(never))]
#[cfg_attr(not(target_os = "none"), inline)]
const fn limited_raw(value: I32F32, limit: I32F32) -> I32F32 {
    let (bits, end_bits) = (value.to_bits(), limit.to_bits());
    if bits > end_bits {
        limit
    } else if bits < -end_bits {
        I32F32::from_bits(-end_bits)
    } else {
        value
    }
}

/// Limits `value` to `low..=high` and returns whether that changed it. A value within the limits
/// costs least.
#[inline(always)]
pub(super) fn limit<Q: Quantity>(value: &mut Q, low: Q, high: Q) -> bool {
    let end = if *value > high {
        high
    } else if *value < low {
        low
    } else {
        return false;
    };
    cold_path();
    *value = end;
    true
}

/// Limits `value` to `-down..=up` and returns whether that changed it. All of them are below 2^30.
#[inline(always)]
pub(super) fn limit_between<Q: Quantity>(value: &mut Q, down: Q, up: Q) -> bool {
    let end = if *value > up {
        up
    } else if value.raw() + down.raw() < I32F32::ZERO {
        Q::from_raw(-down.raw())
    } else {
        return false;
    };
    cold_path();
    *value = end;
    true
}

/// Limits `value` to a whole `end` on either side of zero.
#[inline(always)]
pub(super) fn limit_whole<Q: Quantity>(value: &mut Q, end: i32) {
    // The value rounded down is below a whole number exactly where the value is.
    let whole = (value.raw().to_bits() >> 32) as i32;
    let end = if whole >= end {
        end
    } else if whole < -end {
        -end
    } else {
        return;
    };
    cold_path();
    *value = Q::from_raw(I32F32::from_bits(i64::from(end) << 32));
}

/// Half away from zero, so that a cast to an integer rounds to the nearest one, also in constant
/// expressions.
pub(crate) const fn round(value: f64) -> f64 {
    // From 2^52 on there are only integers, and adding a half would round.
    const INTEGERS: f64 = (1u64 << 52) as f64;
    if value >= INTEGERS || value <= -INTEGERS {
        value
    } else if value < 0.0 {
        value - 0.5
    } else {
        value + 0.5
    }
}
