//! The motor as the paper models it: a first-order lag from duty to rate, and an integrator.
//!
//! For a constant duty with steady rate `W = K u` (deg/s), equation (2) of the paper has the exact
//! solution
//!
//! ```text
//! w(t)     = w0 + (w0 - W) D(t)                       D(t) = exp(-t/tau) - 1
//! theta(t) = theta0 + W t - tau (w0 - W) D(t)
//! ```
//!
//! `D` is tabulated for the ticks of a PWM period, so every tick is computed in one step from the
//! start of the period, and one step over the whole period is as exact as 20 small ones. After the
//! bridge has switched off, `W` is 0: the motor is braked with the same time constant.

pub mod lanes;
mod motion;

use self::motion::{Lag, Motion, Response};
use super::{PERIOD, Plant, PlantState, Pwm, bridge_duty_pct};
use crate::limits::{hard_stop, within};
use crate::parameter::ParameterError;
use crate::time::TICK_S;

crate::parameters! {
    /// Parameters of the first-order motor, equation (2) of the paper as this project reads it.
    pub struct FirstOrderParameters {
        /// Steady rate per duty for positive duty.
        motor_gain_up ["Kup"]: 2.836, "(deg/s)/%", 0.0, 1000.0, "paper, eq. (2), read as G(s) = 2.836/(1 + 0.1318 s)";
        /// Steady rate per duty for negative duty.
        motor_gain_down ["Kdn"]: 2.836, "(deg/s)/%", 0.0, 1000.0, "paper, eq. (2), read as G(s) = 2.836/(1 + 0.1318 s)";
        /// Time constant of the rate.
        motor_time_constant_s ["tau"]: 1.0 / 7.586, "s", 1e-4, 100.0, "paper, eq. (2): pole at 7.586 rad/s";
        /// Maximum rate in positive direction.
        rate_limit_up_deg_s ["rup"]: f64::INFINITY, "deg/s", 0.0, f64::INFINITY, "none beyond the duty limit";
        /// Maximum rate in negative direction.
        rate_limit_down_deg_s ["rdn"]: f64::INFINITY, "deg/s", 0.0, f64::INFINITY, "none beyond the duty limit";
        /// Hard stops at plus and minus this angle.
        position_limit_deg ["pos"]: 180.0, "deg", 0.0, 32000.0, "paper, section III.A: deflection limit of 180 degrees";
    }
}

/// The ticks of a period, in columns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ticks {
    /// Angle of the output shaft, deg.
    pub angle_deg: [f64; PERIOD],
    /// Rate of the output shaft, deg/s.
    pub rate_deg_s: [f64; PERIOD],
}

/// The first-order motor with its PWM bridge.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FirstOrder {
    #[cfg_attr(feature = "serde", serde(with = "crate::parameter::as_values"))]
    parameters: FirstOrderParameters,
    pwm: Pwm,
    lag: Lag,
    response: Response,
    now: MotorState,
    /// The states at the ticks of the period, if a limit may act and the closed form does not
    /// apply.
    stepped: [PlantState; PERIOD + 1],
    is_stepped: bool,
}

/// What changes while the motor runs: the running period, its duty, and whether a limit may act in
/// it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FirstOrderState {
    now: MotorState,
    duty_pct: f64,
    is_stepped: bool,
}

/// The running period of a [`FirstOrder`]; the rest of it derives from this and the duty. It is one
/// piece of memory, so that a copy takes few instructions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct MotorState {
    start: PlantState,
    end: PlantState,
}

impl FirstOrder {
    /// A motor at rest at zero.
    ///
    /// # Errors
    /// Names the first parameter outside its range.
    ///
    /// ```
    /// use model_core::plant::{Plant, Pwm, first_order::{FirstOrder, FirstOrderParameters}};
    ///
    /// let mut motor = FirstOrder::try_new(FirstOrderParameters::default(), Pwm::Average).unwrap();
    /// motor.start_period(100.0);
    /// // 283.6 deg/s * (1 - exp(-7.586/s * 1 ms))
    /// assert!((motor.at(20).rate_deg_s - 2.143250).abs() < 1e-6);
    /// ```
    pub fn try_new(parameters: FirstOrderParameters, pwm: Pwm) -> Result<Self, ParameterError> {
        parameters.check()?;
        Ok(Self::of_checked(parameters, pwm))
    }

    /// The same of parameters that were checked.
    pub(crate) fn of_checked(parameters: FirstOrderParameters, pwm: Pwm) -> Self {
        let lag = Lag::new(parameters.motor_time_constant_s);
        Self {
            response: Response::new(&parameters, &lag, pwm, 0.0),
            parameters,
            pwm,
            lag,
            now: MotorState::default(),
            stepped: [PlantState::default(); PERIOD + 1],
            is_stepped: false,
        }
    }

    /// Sets the angle at the end of the running period, deg.
    pub(crate) fn place(&mut self, angle_deg: f64) {
        self.now.end.angle_deg = angle_deg;
    }

    /// The present state.
    #[inline(always)]
    pub(crate) fn state(&self) -> FirstOrderState {
        FirstOrderState {
            now: self.now,
            duty_pct: self.response.duty_pct,
            is_stepped: self.is_stepped,
        }
    }

    /// Continues from a state.
    #[inline(always)]
    pub(crate) fn set_state(&mut self, state: &FirstOrderState) {
        // Compared by their bits, since the response to -0 has other zeros.
        if state.duty_pct.to_bits() != self.response.duty_pct.to_bits() {
            self.respond_to(state.duty_pct);
        }
        self.now = state.now;
        self.is_stepped = state.is_stepped;
        if state.is_stepped {
            self.stepped = self.stepped(&self.response, state.now.start);
        }
    }

    #[inline(always)]
    fn respond_to(&mut self, duty_pct: f64) {
        self.response = Response::new(&self.parameters, &self.lag, self.pwm, duty_pct);
    }

    /// Angle and rate at the ticks 0 to 19 of the running period, for a recording of every tick.
    #[inline(always)]
    pub fn ticks(&self) -> Ticks {
        if self.is_stepped {
            return Ticks {
                angle_deg: core::array::from_fn(|j| self.stepped[j].angle_deg),
                rate_deg_s: core::array::from_fn(|j| self.stepped[j].rate_deg_s),
            };
        }
        let mut ticks = self.lag.ticks(&self.response.driven.plus(self.now.start));
        if self.response.off_from < PERIOD {
            let braked = self.lag.ticks(&self.response.braked.plus(self.now.start));
            for j in self.response.off_from..PERIOD {
                ticks.angle_deg[j] = braked.angle_deg[j];
                ticks.rate_deg_s[j] = braked.rate_deg_s[j];
            }
        }
        ticks
    }

    /// Whether no limit can act within the period.
    #[inline(always)]
    fn runs_free(&self) -> bool {
        let p = &self.parameters;
        let (rate, target) = (self.now.start.rate_deg_s, self.response.driven.target_deg_s);
        let reach_deg = reach_deg(rate, target);
        let is_allowed = |rate| rate <= p.rate_limit_up_deg_s && rate >= -p.rate_limit_down_deg_s;
        self.now.start.angle_deg.abs() + reach_deg < p.position_limit_deg
            && is_allowed(rate)
            && is_allowed(target)
    }

    /// The states at the ticks of a period that starts like this, tick by tick with the limits
    /// applied after each.
    #[cold]
    fn stepped(&self, response: &Response, start: PlantState) -> [PlantState; PERIOD + 1] {
        let (on_ticks, target) = (response.on_ticks, response.driven.target_deg_s);
        let edge = on_ticks - libm::floor(on_ticks);
        let towards = |target_deg_s, start| Motion {
            start,
            target_deg_s,
        };
        let mut states = [start; PERIOD + 1];
        for tick in 0..PERIOD {
            let on = on_ticks - tick as f64;
            let state = states[tick];
            let next = if on >= 1.0 {
                self.lag.at(&towards(target, state), 1)
            } else if on > 0.0 {
                let switched = self.lag.between(&towards(target, state), edge);
                self.lag.between(&towards(0.0, switched), 1.0 - edge)
            } else {
                self.lag.at(&towards(0.0, state), 1)
            };
            states[tick + 1] = self.within_limits(next);
        }
        states
    }

    /// Applies the rate limit and the inelastic hard stop.
    fn within_limits(&self, state: PlantState) -> PlantState {
        let p = &self.parameters;
        let rate = within(
            state.rate_deg_s,
            -p.rate_limit_down_deg_s,
            p.rate_limit_up_deg_s,
        );
        let (angle_deg, rate_deg_s) = hard_stop(state.angle_deg, rate, p.position_limit_deg);
        PlantState {
            angle_deg,
            rate_deg_s,
        }
    }
}

/// State at the end of a period without limits, with the response to its duty.
#[inline(always)]
fn free_end(start: PlantState, decay: f64, tau_s: f64, forced: PlantState) -> PlantState {
    let lost_deg_s = start.rate_deg_s * decay;
    let coasted_deg = tau_s * lost_deg_s;
    PlantState {
        angle_deg: start.angle_deg - coasted_deg + forced.angle_deg,
        rate_deg_s: start.rate_deg_s + lost_deg_s + forced.rate_deg_s,
    }
}

/// How far the angle may move within a period that starts with this rate towards this one.
#[inline(always)]
fn reach_deg(rate_deg_s: f64, target_deg_s: f64) -> f64 {
    // The rate remains between its start, the target and, if braked, zero. The angle therefore
    // changes by less than the sum of both times the period; one more tick covers the rounding.
    (rate_deg_s.abs() + target_deg_s.abs()) * ((PERIOD + 1) as f64 * TICK_S)
}

impl Plant for FirstOrder {
    #[inline(always)]
    fn start_period(&mut self, duty_pct: f64) {
        let duty_pct = bridge_duty_pct(duty_pct);
        // The duty changes at most every fourth period, so its response is cached.
        if duty_pct != self.response.duty_pct {
            self.respond_to(duty_pct);
        }
        self.now.start = self.now.end;
        self.is_stepped = !self.runs_free();
        if self.is_stepped {
            self.stepped = self.stepped(&self.response, self.now.start);
            self.now.end = self.stepped[PERIOD];
        } else {
            let lag = &self.lag;
            self.now.end = free_end(
                self.now.start,
                lag.decay[PERIOD],
                lag.tau_s,
                self.response.end,
            );
        }
    }

    #[inline(always)]
    fn at(&self, tick_in_period: usize) -> PlantState {
        match tick_in_period {
            0 => self.now.start,
            PERIOD.. => self.now.end,
            tick if self.is_stepped => self.stepped[tick],
            tick if tick < self.response.off_from => self
                .lag
                .at(&self.response.driven.plus(self.now.start), tick),
            tick => self
                .lag
                .at(&self.response.braked.plus(self.now.start), tick),
        }
    }
}

#[cfg(test)]
mod tests;
