//! The motor as the paper models it: a first-order lag from duty to rate, and an integrator.

crate::parameters! {
    /// Parameters of the first-order motor, equation (2) of the paper as this project reads it.
    pub struct FirstOrderParameters {
        /// Steady rate per duty for positive duty.
        motor_gain_up ["Kup"]: 2.836, "(deg/s)/%", 0.0, 1000.0, "paper, eq. (2), read as G(s) = 2.836/(1 + 0.1318 s)";
        /// Steady rate per duty for negative duty.
        motor_gain_down ["Kdn"]: 2.836, "(deg/s)/%", 0.0, 1000.0, "paper, eq. (2), read as G(s) = 2.836/(1 + 0.1318 s)";
        /// Time constant of the rate.
        motor_time_constant_s ["tau"]: 1.0 / 7.586, "s", 1e-4, 100.0, "paper, eq. (2): pole at 7.586 rad/s";
        /// Greatest rate upward.
        rate_limit_up_deg_s ["rup"]: f64::INFINITY, "deg/s", 0.0, f64::INFINITY, "none beyond the duty limit";
        /// Greatest rate downward.
        rate_limit_down_deg_s ["rdn"]: f64::INFINITY, "deg/s", 0.0, f64::INFINITY, "none beyond the duty limit";
        /// Hard stops at plus and minus this angle.
        position_limit_deg ["pos"]: 180.0, "deg", 0.0, 32000.0, "paper, section III.A: deflection limit of 180 degrees";
    }
}
