//! The inner loop: PI on the rate, with feed-forward, duty and slew limits, and back-calculation.
//!
//! ```text
//!   e = r - rate
//!   v = Kp e + x + Kff r
//!   u = v limited to the duty limits and to one slew step from the last u
//!   x = x + T Ki e + T Kaw (u - v)
//! ```
//!
//! The anti-windup feeds back the action of every limiter (`u - v`). With `Kaw = Ki/Kp` this is the
//! external-reset form, whose integrator cannot leave the duty limits.
//!
//! Bounds: `|r| <= 2^17`, `|rate| < 2^16`, so `|e| < 2^18`; `Kp, Kff < 2^7`, so `|Kp e| < 2^25`
//! and `|Kff r| <= 2^24`; `|x| <= 2^28`, hence `|v|, |u - v| < 2^29`. With `T Ki < 2` and
//! `T Kaw <= 1` the new `x` is below `2^28 + 2^19 + 2^29 < 2^30` before it is limited to 2^28.
//! All of it fits the +-2^31 of [`Percent`].

use super::{
    arithmetic::Gain,
    units::{Percent, Rate, limit, limit_between, limit_whole},
};

/// Limit of the integrator in any case: far beyond any duty.
const INTEGRATOR_END: i32 = 1 << 28;

/// Coefficients of the rate loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RateLoop<const VECTOR: bool = false> {
    /// Kp, %/(deg/s), below 2^7.
    pub proportional: Gain<Rate, Percent, VECTOR>,
    /// Ki times the control period, %/(deg/s), below 2.
    pub integral: Gain<Rate, Percent, VECTOR>,
    /// Kaw times the control period, 0 to 1.
    pub anti_windup: Gain<Percent, Percent, VECTOR>,
    /// Kff, %/(deg/s), below 2^7.
    pub feed_forward: Gain<Rate, Percent, VECTOR>,
    /// Greatest magnitude of the duty, 0 to 100 %.
    pub duty_limit: Percent,
    /// Greatest change of the duty in one period, 0 to 200 %.
    pub duty_step: Percent,
}

/// The duty of one step and the limiters that acted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LimitedDuty {
    /// The duty, within the duty limit.
    pub duty: Percent,
    /// Whether the duty limit changed it.
    pub duty_limited: bool,
    /// Whether the slew limit changed it.
    pub slew_limited: bool,
}

/// State of the rate loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RateLoopState {
    pub(super) integrator: Percent,
    duty: Percent,
    /// The last duty before its limits.
    unlimited: Percent,
}

impl RateLoopState {
    /// The state after a step with this duty.
    #[inline(always)]
    pub(super) const fn of(integrator: Percent, duty: Percent) -> Self {
        Self {
            integrator,
            duty,
            unlimited: duty,
        }
    }

    /// One control period: from commanded and estimated rate to the duty.
    #[cfg_attr(target_os = "none", inline(never))]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub fn regulate<const VECTOR: bool>(
        &mut self,
        gains: &RateLoop<VECTOR>,
        command: Rate,
        rate: Rate,
    ) -> LimitedDuty {
        let error = command - rate;
        let unlimited = self.pi_output(gains, command, rate);
        self.unlimited = unlimited;
        // Both products of the error stand together: the compiler splits the error into digits
        // once.
        let grown = gains.integral.times(error);
        let limited = self.limited(gains, unlimited);
        let correction = grown + gains.anti_windup.times(limited.duty - unlimited);
        self.integrator += correction;
        limit_whole(&mut self.integrator, INTEGRATOR_END);
        self.duty = limited.duty;
        limited
    }

    /// A duty within the limits of duty and slew.
    #[inline(always)]
    pub(super) fn limited<const VECTOR: bool>(
        &self,
        gains: &RateLoop<VECTOR>,
        unlimited: Percent,
    ) -> LimitedDuty {
        let mut limited = unlimited;
        let duty_limited = limit_between(&mut limited, gains.duty_limit, gains.duty_limit);
        let mut duty = limited;
        let (least, most) = (self.duty - gains.duty_step, self.duty + gains.duty_step);
        let mut slew_limited = limit(&mut duty, least, most);
        // The last duty may lie outside limits that were narrowed since: the limit has priority.
        if slew_limited && limit_between(&mut duty, gains.duty_limit, gains.duty_limit) {
            slew_limited = duty != limited;
        }
        LimitedDuty {
            duty,
            duty_limited,
            slew_limited,
        }
    }

    /// Limits the duty of the last step to what the motor may take at present; the anti-windup
    /// feeds back what that takes away. Returns the duty if it was changed.
    pub fn limit_duty(
        &mut self,
        gains: &RateLoop,
        (least, most): (Percent, Percent),
    ) -> Option<Percent> {
        let mut duty = self.duty;
        if !limit(&mut duty, least, most) {
            return None;
        }
        self.integrator += gains.anti_windup.times(duty - self.duty);
        limit_whole(&mut self.integrator, INTEGRATOR_END);
        self.duty = duty;
        Some(duty)
    }

    /// Moves the jump of the duty that new coefficients would cause into the integrator.
    pub fn absorb(&mut self, jump: Percent) {
        self.integrator -= jump;
        limit_whole(&mut self.integrator, INTEGRATOR_END);
    }

    /// The duty of the last step before its limits.
    pub fn unlimited(&self) -> Percent {
        self.unlimited
    }

    #[inline(always)]
    fn pi_output<const VECTOR: bool>(
        &self,
        gains: &RateLoop<VECTOR>,
        command: Rate,
        rate: Rate,
    ) -> Percent {
        gains.proportional.times(command - rate)
            + self.integrator
            + gains.feed_forward.times(command)
    }
}
