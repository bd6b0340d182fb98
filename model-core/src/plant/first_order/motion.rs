//! Closed forms: free motion towards a steady rate, and the response to a duty within a period.

use super::{FirstOrderParameters, Ticks};
use crate::plant::{PERIOD, PlantState, Pwm};
use crate::time::TICK_S;

/// The times of the ticks of a period, s.
pub(super) const TIMES_S: [f64; PERIOD + 1] = {
    let mut times_s = [0.0; PERIOD + 1];
    let mut tick = 0;
    while tick <= PERIOD {
        times_s[tick] = tick as f64 * TICK_S;
        tick += 1;
    }
    times_s
};

/// The lag of the motor: `D` at every tick of a period.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Lag {
    pub tau_s: f64,
    pub decay: [f64; PERIOD + 1],
}

impl Lag {
    pub fn new(tau_s: f64) -> Self {
        let decay = core::array::from_fn(|tick| decay_over(tick as f64, tau_s));
        Self { tau_s, decay }
    }

    /// State of a motion at a tick of the period.
    #[inline(always)]
    pub fn at(&self, motion: &Motion, tick: usize) -> PlantState {
        motion.after(TIMES_S[tick], self.decay[tick], self.tau_s)
    }

    /// States of a motion at all ticks of the period except the last: branch-free loops of constant
    /// length, which the compiler vectorises.
    #[inline(always)]
    pub fn ticks(&self, motion: &Motion) -> Ticks {
        let mut ticks = Ticks {
            angle_deg: [0.0; PERIOD],
            rate_deg_s: [0.0; PERIOD],
        };
        for j in 0..PERIOD {
            let state = self.at(motion, j);
            ticks.angle_deg[j] = state.angle_deg;
            ticks.rate_deg_s[j] = state.rate_deg_s;
        }
        ticks
    }

    /// State of a motion at any time of the period, in ticks.
    pub fn between(&self, motion: &Motion, ticks: f64) -> PlantState {
        motion.after(ticks * TICK_S, decay_over(ticks, self.tau_s), self.tau_s)
    }
}

fn decay_over(ticks: f64, tau_s: f64) -> f64 {
    libm::expm1(-(ticks * TICK_S) / tau_s)
}

/// A free motion towards a steady rate, defined by its state at tick 0 (extrapolated if it starts
/// later).
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Motion {
    pub start: PlantState,
    pub target_deg_s: f64,
}

impl Motion {
    #[inline(always)]
    pub(super) fn after(&self, time_s: f64, decay: f64, tau_s: f64) -> PlantState {
        let excess_deg_s = self.start.rate_deg_s - self.target_deg_s;
        PlantState {
            angle_deg: self.start.angle_deg + self.target_deg_s * time_s
                - tau_s * excess_deg_s * decay,
            rate_deg_s: self.start.rate_deg_s + excess_deg_s * decay,
        }
    }

    /// The superposition of this motion and a start state.
    #[inline(always)]
    pub fn plus(&self, start: PlantState) -> Self {
        Self {
            start: PlantState {
                angle_deg: self.start.angle_deg + start.angle_deg,
                rate_deg_s: self.start.rate_deg_s + start.rate_deg_s,
            },
            ..*self
        }
    }
}

/// Response of a motor at rest at zero to a duty within one period.
///
/// The motor is linear between its limits, so its motion is this response plus the decay of its
/// initial rate.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Response {
    pub duty_pct: f64,
    /// On time of the bridge in ticks; the whole period if it does not switch.
    pub on_ticks: f64,
    /// The motion before and from tick `off_from`.
    pub driven: Motion,
    pub braked: Motion,
    pub off_from: usize,
    /// The state at tick 20.
    pub end: PlantState,
}

impl Response {
    /// The response to a duty from -100 to 100 %.
    #[inline]
    pub fn new(p: &FirstOrderParameters, lag: &Lag, pwm: Pwm, duty_pct: f64) -> Self {
        let gain = if duty_pct > 0.0 {
            p.motor_gain_up
        } else {
            p.motor_gain_down
        };
        let (level_pct, on_ticks) = match pwm {
            Pwm::Average => (duty_pct, PERIOD as f64),
            Pwm::Switched => (
                libm::copysign(100.0, duty_pct),
                duty_pct.abs() / 100.0 * PERIOD as f64,
            ),
        };
        let driven = Motion {
            start: PlantState::default(),
            target_deg_s: gain * level_pct,
        };
        // `on_ticks` is from 0 to 20.
        let off_from = on_ticks as usize + 1;
        let braked = if off_from > PERIOD {
            driven
        } else {
            braked_from(lag, lag.between(&driven, on_ticks), on_ticks)
        };
        Self {
            duty_pct,
            on_ticks,
            driven,
            braked,
            off_from,
            end: lag.at(&braked, PERIOD),
        }
    }
}

/// The braked motion through a state, extrapolated back to tick 0.
fn braked_from(lag: &Lag, passed: PlantState, ticks: f64) -> Motion {
    let decay = decay_over(ticks, lag.tau_s);
    // The time constant is at least 1e-4 s, hence 1 + D at least exp(-10) within the period.
    let rate_deg_s = passed.rate_deg_s / (1.0 + decay);
    let angle_deg = passed.angle_deg + lag.tau_s * rate_deg_s * decay;
    Motion {
        start: PlantState {
            angle_deg,
            rate_deg_s,
        },
        target_deg_s: 0.0,
    }
}
