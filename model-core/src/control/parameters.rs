//! The parameters of the control step in engineering units.

use crate::parameter::{self, Parameters};
use crate::time::CONTROL_RATE_HZ;

impl ControlParameters {
    /// The row of a parameter in the table, for constant expressions.
    ///
    /// # Panics
    /// Those of [`parameter::row`].
    pub const fn row(name: &str) -> usize {
        parameter::row(Self::TABLE, name)
    }
}

/// Share of a new encoder difference: 7.8 ms of time constant, `1 - 0.6^(250 Hz/rate)`.
const RATE_FILTER: f64 = match CONTROL_RATE_HZ {
    250 => 0.4,
    1_000 => 0.12,
    _ => panic!("no filter for this rate"),
};

crate::parameters! {
    /// Gains and limits of the control step; the presets of [`crate::presets`] set them.
    pub struct ControlParameters {
        /// Gain of the position loop.
        position_gain ["P"]: 8.0, "1/s", 0.0, 500.0, "paper, section II.B: outer loop gain of eight";
        /// Proportional gain of the rate loop.
        proportional_gain ["Kp"]: 10.0 / 7.586, "%/(deg/s)", 0.0, 100.0, "paper, eq. (1), read as F(s) = 10 (1 + 0.1318 s)/s";
        /// Integral gain of the rate loop.
        integral_gain ["Ki"]: 10.0, "%/deg", 0.0, 400.0, "paper, eq. (1), read as F(s) = 10 (1 + 0.1318 s)/s";
        // At the control rate the integrator follows the limited output within one period.
        /// Gain of the anti-windup by back-calculation.
        anti_windup_gain ["Kaw"]: 7.586, "1/s", 0.0, CONTROL_RATE_HZ as f64, "1/Ti, the external-reset form; the paper prints none";
        /// Feed-forward from the commanded rate to the duty that balances its back-EMF.
        feed_forward_gain ["Kff"]: 0.0, "%/(deg/s)", 0.0, 100.0, "none in the paper; 1/K of the motor balances the back-EMF";
        /// Share of a new encoder difference that enters the rate estimate.
        rate_filter ["alpha"]: RATE_FILTER, "1", 0.001, 1.0, "at most 21 % duty ripple at rest; the paper prints none";
        /// Least position command.
        position_min_deg [""]: -32768.0, "deg", -32768.0, 32767.0, "widest";
        /// Greatest position command.
        position_max_deg [""]: 32767.0, "deg", -32768.0, 32767.0, "widest";
        /// Greatest commanded rate upward.
        rate_command_limit_up_deg_s ["rcmd_up"]: f64::INFINITY, "deg/s", 0.0, f64::INFINITY, "widest";
        /// Greatest commanded rate downward.
        rate_command_limit_down_deg_s ["rcmd_dn"]: f64::INFINITY, "deg/s", 0.0, f64::INFINITY, "widest";
        /// Greatest magnitude of the duty.
        duty_limit_pct ["umax"]: 100.0, "%", 0.0, 100.0, "the whole bridge";
        /// Greatest change of the duty per second.
        duty_slew_pct_s [""]: f64::INFINITY, "%/s", 0.0, f64::INFINITY, "widest";
        /// Encoder angle that counts as zero.
        encoder_zero_deg [""]: 0.0, "deg", -180.0, 180.0, "magnet glued at zero";
        /// Sense of the encoder: 1 where its angle grows with positive duty, -1 where it falls.
        encoder_direction [""]: 1.0, "1", -1.0, 1.0, "magnet seen from the side of the chip";
    }
}
