//! Limits of signals, shared by the control path and the models.

/// `value` limited to `low..=high`; NaN remains NaN. Unlike `clamp` it cannot panic.
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

/// The second of equal numbers; `f64::min` handles NaN in addition.
#[inline(always)]
pub(crate) fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The second of equal numbers.
#[inline(always)]
pub(crate) fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// `value` limited to plus and minus a limit that is not negative.
#[inline(always)]
pub(crate) fn limited(value: f64, limit: f64) -> f64 {
    // The limit first: of equal zeros the value remains.
    lesser(limit, greater(-limit, value))
}

/// Angle and rate after inelastic hard stops at plus and minus `limit_deg`, which set an outward
/// rate to zero.
#[inline]
pub(crate) fn hard_stop(angle_deg: f64, rate_deg_s: f64, limit_deg: f64) -> (f64, f64) {
    let stopped_deg = within(angle_deg, -limit_deg, limit_deg);
    if stopped_deg != angle_deg && stopped_deg * rate_deg_s > 0.0 {
        (stopped_deg, 0.0)
    } else {
        (stopped_deg, rate_deg_s)
    }
}
