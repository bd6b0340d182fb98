//! The numbers of the control path.
//!
//! An encoder count is 45/512 deg, so that every measured angle and every difference quotient
//! `counts * 45/512 deg / 4 ms` is exact in 16 fractional bits.

use fixed::types::{I16F16, I32F32};

/// An angle, deg: +-32,768 deg (91 turns) in steps of 1.5e-5 deg.
pub type Angle = I16F16;

/// An angular rate, deg/s: +-32,768 deg/s in steps of 1.5e-5 deg/s.
pub type Rate = I16F16;

/// A share of the supply voltage before it is limited, %, in steps of 2.3e-10 %.
pub type Percent = I32F32;

/// The angle nearest to `degrees`; beyond its ends the last one, for NaN zero.
///
/// ```
/// use model_core::control::units::{Angle, angle};
/// assert_eq!(angle(45.0 / 512.0), Angle::from_bits(45 << 7));
/// assert_eq!(angle(1e9), Angle::MAX);
/// assert_eq!(angle(f64::NAN), Angle::ZERO);
/// ```
pub fn angle(degrees: f64) -> Angle {
    // `as` saturates and takes NaN to 0; `round` keeps the error within half a step.
    Angle::from_bits(libm::round(degrees * 65536.0) as i32)
}
