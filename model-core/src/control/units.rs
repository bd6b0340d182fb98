//! The numbers of the control path.
//!
//! An encoder count is 45/512 deg, so every measured angle is exact in 9 fractional bits, and so
//! is every difference quotient `counts * 45/512 deg / 4 ms`. The other 23 bits serve the commands:
//! where a loop hunts around one encoder count, a command that is off by 1e-5 deg moves the instant
//! at which the count changes, and the trace is another one from there on.

use core::hint::cold_path;

use fixed::types::I32F32;

/// An angle, deg, in steps of 2.3e-10 deg.
pub type Angle = I32F32;

/// The control step takes angles within +-32,768 deg, 91 turns; what lies beyond is held there.
pub const ANGLE_END: Angle = Angle::const_from_int(1 << 15);

/// An angular rate, deg/s, in steps of 2.3e-10 deg/s.
pub type Rate = I32F32;

/// A share of the supply voltage, %, in steps of 2.3e-10 %.
pub type Percent = I32F32;

/// The angle nearest to `degrees`; beyond its ends the last one, for NaN zero.
///
/// ```
/// use model_core::control::units::{Angle, angle};
/// assert_eq!(angle(45.0 / 512.0), Angle::from_bits(45 << 23));
/// assert_eq!(angle(1e10), Angle::MAX);
/// assert_eq!(angle(f64::NAN), Angle::ZERO);
/// ```
pub const fn angle(degrees: f64) -> Angle {
    nearest(degrees)
}

/// The number in steps of 2^-32 that lies nearest to `value`; saturates, NaN gives zero.
///
/// ```
/// use model_core::control::units::{Percent, percent};
/// assert_eq!(percent(100.0), Percent::from_num(100));
/// assert_eq!(percent(f64::INFINITY), Percent::MAX);
/// ```
pub const fn percent(value: f64) -> Percent {
    nearest(value)
}

/// The number in floating point, to 53 bits; the general conversion of the `fixed` crate goes bit
/// by bit.
///
/// ```
/// use model_core::control::units::{angle, float};
/// assert_eq!(float(angle(-45.0 / 512.0)), -45.0 / 512.0);
/// ```
pub const fn float(value: I32F32) -> f64 {
    value.to_bits() as f64 / 4_294_967_296.0
}

/// The number in steps of 2^-32 that lies nearest to `value`; saturates, NaN gives zero.
const fn nearest(value: f64) -> I32F32 {
    // The cast saturates and takes NaN to 0.
    I32F32::from_bits(round(value * 4_294_967_296.0) as i64)
}

/// `value` within `end` of zero, either way; `end` is not negative. On the board all who limit a signal
/// share this one.
///
/// ```
/// use model_core::control::units::{angle, held};
/// assert_eq!([-3.0, 1.0, 3.0].map(|deg| held(angle(deg), angle(2.0))), [-2, 1, 2].map(|deg| angle(deg.into())));
/// ```
#[cfg_attr(target_os = "none", inline(never))]
#[cfg_attr(not(target_os = "none"), inline)]
pub const fn held(value: I32F32, end: I32F32) -> I32F32 {
    let (bits, end_bits) = (value.to_bits(), end.to_bits());
    if bits > end_bits {
        end
    } else if bits < -end_bits {
        I32F32::from_bits(-end_bits)
    } else {
        value
    }
}

/// Moves `value` into `low..=high`; whether it had to. Where it lies there already costs least.
#[inline(always)]
pub(super) fn hold(value: &mut I32F32, low: I32F32, high: I32F32) -> bool {
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

/// Moves `value` into `-down..=up`; whether it had to. All of them are below 2^30.
#[inline(always)]
pub(super) fn hold_between(value: &mut I32F32, down: I32F32, up: I32F32) -> bool {
    let nearest = if *value > up {
        up
    } else if *value + down < 0 {
        -down
    } else {
        return false;
    };
    cold_path();
    *value = nearest;
    true
}

/// Moves `value` to within a whole `end` of zero, either way.
#[inline(always)]
pub(super) fn hold_whole(value: &mut I32F32, end: i32) {
    // What is rounded down is below a whole number where the value is.
    let whole = (value.to_bits() >> 32) as i32;
    let end = if whole >= end {
        end
    } else if whole < -end {
        -end
    } else {
        return;
    };
    cold_path();
    *value = I32F32::const_from_int(end.into());
}

/// What a cast to an integer makes the nearest one of, in constant expressions too.
pub(crate) const fn round(value: f64) -> f64 {
    // From 2^52 on there are only integers, and a half more would be rounded itself.
    const INTEGERS: f64 = (1u64 << 52) as f64;
    if value >= INTEGERS || value <= -INTEGERS {
        value
    } else if value < 0.0 {
        value - 0.5
    } else {
        value + 0.5
    }
}
