//! The motor as the paper models it: a first-order lag from duty to rate, and an integrator.
//!
//! With the bridge holding the steady rate `W = K u` (deg/s), equation (2) of the paper has the
//! exact solution
//!
//! ```text
//! w(t)     = w0 + (w0 - W) D(t)                       D(t) = exp(-t/tau) - 1
//! theta(t) = theta0 + W t - tau (w0 - W) D(t)
//! ```
//!
//! `D` is tabulated for the ticks of a PWM period, so every tick is reached in one step from the
//! start of the period, and one step over the whole period is as exact as 20 small ones.
//! Once the bridge has switched off, `W` is 0: the motor is braked with the same time constant.

use super::{PERIOD, Plant, PlantState, Pwm, bridge_duty_pct, limited};
use crate::parameter::{ParameterError, Parameters};
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
        /// Greatest rate upward.
        rate_limit_up_deg_s ["rup"]: f64::INFINITY, "deg/s", 0.0, f64::INFINITY, "none beyond the duty limit";
        /// Greatest rate downward.
        rate_limit_down_deg_s ["rdn"]: f64::INFINITY, "deg/s", 0.0, f64::INFINITY, "none beyond the duty limit";
        /// Hard stops at plus and minus this angle.
        position_limit_deg ["pos"]: 180.0, "deg", 0.0, 32000.0, "paper, section III.A: deflection limit of 180 degrees";
    }
}

/// The first-order motor behind a PWM bridge.
#[derive(Debug, Clone)]
pub struct FirstOrder {
    parameters: FirstOrderParameters,
    pwm: Pwm,
    /// `D` at every tick of a period.
    decay: [f64; PERIOD + 1],
    bridge: Bridge,
    start: PlantState,
    end: PlantState,
    /// The period at its ticks, where a limit may act and no closed form holds.
    stepped: [PlantState; PERIOD + 1],
    is_stepped: bool,
}

/// What a duty makes of a period: how a motor at rest at zero would move.
///
/// The motor is linear between its limits. So its motion is this one, plus the decay of the rate
/// that it starts with.
#[derive(Debug, Clone, Copy, Default)]
struct Bridge {
    duty_pct: f64,
    /// How long the bridge is on, ticks; the whole period where it does not switch.
    on_ticks: f64,
    /// The motion before tick `off_from`, and from it on.
    driven: Segment,
    braked: Segment,
    off_from: usize,
    end: PlantState,
}

/// A free motion towards a steady rate, told by where it is, or would have been, at tick 0.
#[derive(Debug, Clone, Copy, Default)]
struct Segment {
    start: PlantState,
    target_deg_s: f64,
}

impl Segment {
    #[inline(always)]
    fn at(&self, time_s: f64, decay: f64, tau_s: f64) -> PlantState {
        let excess_deg_s = self.start.rate_deg_s - self.target_deg_s;
        PlantState {
            angle_deg: self.start.angle_deg + self.target_deg_s * time_s
                - tau_s * excess_deg_s * decay,
            rate_deg_s: self.start.rate_deg_s + excess_deg_s * decay,
        }
    }

    /// The same motion from another start.
    #[inline(always)]
    fn plus(&self, start: PlantState) -> Self {
        Self {
            start: PlantState {
                angle_deg: self.start.angle_deg + start.angle_deg,
                rate_deg_s: self.start.rate_deg_s + start.rate_deg_s,
            },
            ..*self
        }
    }
}

impl FirstOrder {
    /// A motor at rest at zero.
    ///
    /// # Errors
    /// That of the first parameter outside its range.
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
        let tau_s = parameters.motor_time_constant_s;
        let mut motor = Self {
            parameters,
            pwm,
            decay: core::array::from_fn(|j| libm::expm1(-(j as f64 * TICK_S) / tau_s)),
            bridge: Bridge::default(),
            start: PlantState::default(),
            end: PlantState::default(),
            stepped: [PlantState::default(); PERIOD + 1],
            is_stepped: false,
        };
        motor.bridge = motor.latch(0.0);
        Ok(motor)
    }

    /// The states at the ticks 0 to 19 of the running period: a record of every tick.
    #[inline]
    pub fn ticks(&self) -> [PlantState; PERIOD] {
        if self.is_stepped {
            return core::array::from_fn(|j| self.stepped[j]);
        }
        let mut states = [PlantState::default(); PERIOD];
        let (on, off) = states.split_at_mut(self.bridge.off_from.min(PERIOD));
        self.fill(on, 0, &self.bridge.driven);
        self.fill(off, self.bridge.off_from, &self.bridge.braked);
        states
    }

    #[inline(always)]
    fn fill(&self, states: &mut [PlantState], first_tick: usize, segment: &Segment) {
        let segment = segment.plus(self.start);
        for (j, state) in states.iter_mut().enumerate() {
            *state = self.along(&segment, first_tick + j);
        }
    }

    #[inline(always)]
    fn along(&self, segment: &Segment, tick: usize) -> PlantState {
        let tau_s = self.parameters.motor_time_constant_s;
        segment.at(tick as f64 * TICK_S, self.decay[tick], tau_s)
    }

    fn latch(&self, duty_pct: f64) -> Bridge {
        let p = &self.parameters;
        let tau_s = p.motor_time_constant_s;
        let gain = if duty_pct > 0.0 {
            p.motor_gain_up
        } else {
            p.motor_gain_down
        };
        let (level_pct, on_ticks) = match self.pwm {
            Pwm::Average => (duty_pct, PERIOD as f64),
            Pwm::Switched => (
                libm::copysign(100.0, duty_pct),
                duty_pct.abs() / 100.0 * PERIOD as f64,
            ),
        };
        let driven = Segment {
            start: PlantState::default(),
            target_deg_s: gain * level_pct,
        };
        // `on_ticks` is from 0 to 20.
        let off_from = on_ticks as usize + 1;
        if off_from > PERIOD {
            return Bridge {
                duty_pct,
                on_ticks,
                driven,
                braked: driven,
                off_from,
                end: self.along(&driven, PERIOD),
            };
        }
        let decay = self.decay_over(on_ticks);
        let edge = driven.at(on_ticks * TICK_S, decay, tau_s);
        // The braked motion, followed back from the edge to tick 0. The time constant is at least
        // 1e-4 s, hence 1 + D at least exp(-10).
        let rate_deg_s = edge.rate_deg_s / (1.0 + decay);
        let angle_deg = edge.angle_deg + tau_s * rate_deg_s * decay;
        let braked = Segment {
            start: PlantState {
                angle_deg,
                rate_deg_s,
            },
            target_deg_s: 0.0,
        };
        Bridge {
            duty_pct,
            on_ticks,
            driven,
            braked,
            off_from,
            end: self.along(&braked, PERIOD),
        }
    }

    fn decay_over(&self, ticks: f64) -> f64 {
        libm::expm1(-(ticks * TICK_S) / self.parameters.motor_time_constant_s)
    }

    /// Whether no limit can act within a period that starts here.
    #[inline]
    fn runs_free(&self) -> bool {
        let p = &self.parameters;
        let (rate, target) = (self.start.rate_deg_s, self.bridge.driven.target_deg_s);
        // The rate stays between its start, the target and, braked, zero. So the angle moves by
        // less than the sum of both times the period; one tick more covers the rounding.
        let reach_deg = (rate.abs() + target.abs()) * ((PERIOD + 1) as f64 * TICK_S);
        let is_allowed = |rate| rate <= p.rate_limit_up_deg_s && rate >= -p.rate_limit_down_deg_s;
        self.start.angle_deg.abs() + reach_deg < p.position_limit_deg
            && is_allowed(rate)
            && is_allowed(target)
    }

    /// The end of a period without limits.
    #[inline]
    fn free_end(&self) -> PlantState {
        let forced = &self.bridge.end;
        let lost_deg_s = self.start.rate_deg_s * self.decay[PERIOD];
        let coasted_deg = self.parameters.motor_time_constant_s * lost_deg_s;
        PlantState {
            angle_deg: self.start.angle_deg - coasted_deg + forced.angle_deg,
            rate_deg_s: self.start.rate_deg_s + lost_deg_s + forced.rate_deg_s,
        }
    }

    /// Tick by tick, with the limits after each.
    #[cold]
    fn run_stepped(&mut self) {
        let tau_s = self.parameters.motor_time_constant_s;
        let (on_ticks, target) = (self.bridge.on_ticks, self.bridge.driven.target_deg_s);
        let edge = on_ticks - libm::floor(on_ticks);
        let (before, after) = (self.decay_over(edge), self.decay_over(1.0 - edge));
        let moved = |start, target_deg_s, ticks: f64, decay| {
            let segment = Segment {
                start,
                target_deg_s,
            };
            segment.at(ticks * TICK_S, decay, tau_s)
        };
        self.stepped[0] = self.start;
        for tick in 0..PERIOD {
            let on = on_ticks - tick as f64;
            let state = self.stepped[tick];
            let next = if on >= 1.0 {
                moved(state, target, 1.0, self.decay[1])
            } else if on > 0.0 {
                moved(moved(state, target, edge, before), 0.0, 1.0 - edge, after)
            } else {
                moved(state, 0.0, 1.0, self.decay[1])
            };
            self.stepped[tick + 1] = self.within_limits(next);
        }
    }

    /// The state after the rate limit and the inelastic hard stop.
    fn within_limits(&self, state: PlantState) -> PlantState {
        let p = &self.parameters;
        let rate = limited(
            state.rate_deg_s,
            -p.rate_limit_down_deg_s,
            p.rate_limit_up_deg_s,
        );
        let stop = p.position_limit_deg;
        let angle = limited(state.angle_deg, -stop, stop);
        let is_pushed = state.angle_deg.abs() > stop && angle * rate > 0.0;
        PlantState {
            angle_deg: angle,
            rate_deg_s: if is_pushed { 0.0 } else { rate },
        }
    }
}

impl Plant for FirstOrder {
    #[inline]
    fn start_period(&mut self, duty_pct: f64) {
        let duty_pct = bridge_duty_pct(duty_pct);
        // The duty changes at every fourth period at most: what it does is kept till then.
        if duty_pct != self.bridge.duty_pct {
            self.bridge = self.latch(duty_pct);
        }
        self.start = self.end;
        self.is_stepped = !self.runs_free();
        if self.is_stepped {
            self.run_stepped();
            self.end = self.stepped[PERIOD];
        } else {
            self.end = self.free_end();
        }
    }

    #[inline]
    fn at(&self, tick_in_period: usize) -> PlantState {
        match tick_in_period {
            0 => self.start,
            PERIOD.. => self.end,
            tick if self.is_stepped => self.stepped[tick],
            tick if tick < self.bridge.off_from => {
                self.along(&self.bridge.driven.plus(self.start), tick)
            }
            tick => self.along(&self.bridge.braked.plus(self.start), tick),
        }
    }
}

#[cfg(test)]
mod tests;
