//! The inner loop: PI on the rate, with feed-forward, duty and slew limits, and back-calculation.
//!
//! ```text
//!   e = r - rate
//!   v = Kp e + x + Kff r
//!   u = v held within the duty limits and within one slew step of the last u
//!   x = x + T Ki e + T Kaw (u - v)
//! ```
//!
//! Whatever limiter acted, the integrator is told (`u - v`). With `Kaw = Ki/Kp` this is the
//! external-reset form, whose integrator cannot leave the duty limits.
//!
//! Bounds: `|r| <= 2^17`, `|rate| < 2^16`, so `|e| < 2^18`; `Kp, Kff < 2^7`, so `|Kp e| < 2^25`
//! and `|Kff r| <= 2^24`; `|x| <= 2^28`, hence `|v|, |u - v| < 2^29`. With `T Ki < 2` and
//! `T Kaw <= 1` the new `x` is below `2^28 + 2^19 + 2^29 < 2^30` before it is held within 2^28.
//! All of it fits the +-2^31 of [`Percent`].

use super::{
    arithmetic::Coefficient,
    units::{Percent, Rate, hold, hold_between, hold_whole},
};

/// Where the integrator ends if nothing else holds it: far beyond any duty.
const INTEGRATOR_END: i32 = 1 << 28;

/// Coefficients of the rate loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RateLoop {
    /// Kp, %/(deg/s), below 2^7.
    pub proportional: Coefficient,
    /// Ki times the control period, %/(deg/s), below 2.
    pub integral: Coefficient,
    /// Kaw times the control period, 0 to 1.
    pub anti_windup: Coefficient,
    /// Kff, %/(deg/s), below 2^7.
    pub feed_forward: Coefficient,
    /// Greatest magnitude of the duty, 0 to 100 %.
    pub duty_limit: Percent,
    /// Greatest change of the duty in one period, 0 to 200 %.
    pub duty_step: Percent,
}

/// The duty of one step and which limiter acted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LimitedDuty {
    /// The duty, within the duty limit.
    pub duty: Percent,
    /// Whether the duty limit held it back.
    pub duty_limited: bool,
    /// Whether the slew limit held it back.
    pub slew_limited: bool,
}

/// State of the rate loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RateLoopState {
    integrator: Percent,
    duty: Percent,
    /// The last duty before its limits.
    wanted: Percent,
}

impl RateLoopState {
    /// One control period: from commanded and estimated rate to the duty.
    pub fn step(&mut self, gains: &RateLoop, command: Rate, rate: Rate) -> LimitedDuty {
        let error = command - rate;
        let wanted = self.unlimited(gains, command, rate);
        self.wanted = wanted;
        // Both products of the error in one place: the compiler splits it once.
        let grown = gains.integral.times(error);
        let mut limited = wanted;
        let duty_limited = hold_between(&mut limited, gains.duty_limit, gains.duty_limit);
        let mut duty = limited;
        let (least, most) = (self.duty - gains.duty_step, self.duty + gains.duty_step);
        let mut slew_limited = hold(&mut duty, least, most);
        // The last duty may lie outside limits that were narrowed since: the limit wins.
        if slew_limited && hold_between(&mut duty, gains.duty_limit, gains.duty_limit) {
            slew_limited = duty != limited;
        }
        let correction = grown + gains.anti_windup.times(duty - wanted);
        self.integrator += correction;
        hold_whole(&mut self.integrator, INTEGRATOR_END);
        self.duty = duty;
        LimitedDuty {
            duty,
            duty_limited,
            slew_limited,
        }
    }

    /// Takes a jump of the duty, which new coefficients would make, into the integrator.
    pub fn absorb(&mut self, jump: Percent) {
        self.integrator -= jump;
        hold_whole(&mut self.integrator, INTEGRATOR_END);
    }

    /// What the last step would have made the duty without limits.
    pub fn wanted(&self) -> Percent {
        self.wanted
    }

    #[inline(always)]
    fn unlimited(&self, gains: &RateLoop, command: Rate, rate: Rate) -> Percent {
        gains.proportional.times(command - rate)
            + self.integrator
            + gains.feed_forward.times(command)
    }
}
