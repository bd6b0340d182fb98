//! Black box 1: `angle' = sat(p (gain c + offset - angle))`, as [`model_core::models::black_box_1`]
//! steps it.

use std::sync::Arc;

use model_core::models::{SetupParameters, black_box_1::BlackBox1Parameters};

use super::Dynamics;
use super::initial_state::InitialState;
use super::limits::{self, FREE, Limits, RATE_DOWN, RATE_UP, STOP_HIGH, STOP_LOW};
use crate::experiment::Experiment;
use crate::hybrid::{Guard, HybridModel, LinearSystem, Output, simulate};
use crate::model::{ActiveLimit, Description, Model, ModelParameter, ParameterValues, parameters};
use crate::scalar::Scalar;
use crate::start::DataSummary;

/// First-order lag with limits of rate and position, behind a delay.
#[derive(Debug, Clone, Copy)]
pub struct BlackBox1;

parameters! {
    /// Parameters of [`BlackBox1`].
    pub struct BlackBox1Values {
        pole_rad_s: BlackBox1Parameters.within(0.05, 1000.0);
        delay_s: SetupParameters;
        rate_limit_up_deg_s: BlackBox1Parameters.rate_limit();
        rate_limit_down_deg_s: BlackBox1Parameters.rate_limit();
        gain: BlackBox1Parameters.within(-20.0, 20.0);
        offset_deg: BlackBox1Parameters;
        position_limit_deg: BlackBox1Parameters.fixed();
        initial_angle_deg: InitialState.initial_state();
    }
}

pub(super) fn models() -> Vec<Arc<dyn Model>> {
    vec![Arc::new(BlackBox1)]
}

impl Description for BlackBox1 {
    fn name(&self) -> &'static str {
        "black-box-1"
    }

    fn summary(&self) -> &'static str {
        "first-order lag with delay, rate and position limits"
    }

    fn parameters(&self) -> &[ModelParameter] {
        BlackBox1Values::<f64>::TABLE
    }
}

impl Dynamics for BlackBox1 {
    type Parameters<S: Scalar> = BlackBox1Values<S>;

    fn start(&self, experiments: &[Experiment]) -> BlackBox1Values<f64> {
        let data = DataSummary::of(experiments);
        BlackBox1Values {
            pole_rad_s: data.pole_rad_s,
            delay_s: data.delay_s,
            rate_limit_up_deg_s: data.rate_up_deg_s,
            rate_limit_down_deg_s: data.rate_down_deg_s,
            gain: data.gain,
            offset_deg: data.offset_deg,
            position_limit_deg: f64::INFINITY,
            initial_angle_deg: data.initial_angle_deg,
        }
    }

    #[inline(always)]
    fn run<S: Scalar>(
        &self,
        run: &Experiment,
        p: &BlackBox1Values<S>,
        output: &mut impl Output<S>,
    ) {
        let lag = Lag {
            pole: p.pole_rad_s,
            limits: Limits {
                up: p.rate_limit_up_deg_s,
                down: p.rate_limit_down_deg_s,
                gain: p.gain,
                offset: p.offset_deg,
                stop: p.position_limit_deg,
            },
        };
        simulate(&lag, run, [p.initial_angle_deg], p.delay_s, output);
    }
}

struct Lag<S> {
    pole: S,
    limits: Limits<S>,
}

impl<S: Scalar> Lag<S> {
    /// `sign (p (target - angle)) + more`.
    fn rate(&self, sign: f64, more: S, next: usize) -> Guard<S, 1> {
        let pole = self.pole * sign;
        Guard {
            row: [-pole],
            command: pole * self.limits.gain,
            constant: pole * self.limits.offset + more,
            next,
        }
    }
}

impl<S: Scalar> HybridModel<S, 1> for Lag<S> {
    const MODES: usize = limits::MODES;

    fn system(&self, mode: usize) -> LinearSystem<S, 1> {
        let zero = S::constant(0.0);
        let Limits {
            up,
            down,
            gain,
            offset,
            ..
        } = self.limits;
        let (a, b, d) = match mode {
            FREE => (-self.pole, self.pole * gain, self.pole * offset),
            RATE_UP => (zero, zero, up),
            RATE_DOWN => (zero, zero, -down),
            _ => (zero, zero, zero),
        };
        LinearSystem {
            a: [[a]],
            b: [b],
            d: [d],
        }
    }

    fn guards(&self, mode: usize) -> Vec<Guard<S, 1>> {
        let zero = S::constant(0.0);
        let (up, down) = (self.limits.up, self.limits.down);
        let mut guards = match mode {
            FREE => vec![
                self.rate(-1.0, up, RATE_UP),
                self.rate(1.0, down, RATE_DOWN),
            ],
            RATE_UP => vec![self.rate(1.0, -up, FREE)],
            RATE_DOWN => vec![self.rate(-1.0, -down, FREE)],
            STOP_HIGH => return vec![self.rate(1.0, zero, FREE)],
            _ => return vec![self.rate(-1.0, zero, FREE)],
        };
        self.limits.stops(&mut guards);
        guards
    }

    fn mode_at(&self, x: &[f64; 1], command: f64) -> usize {
        let rate = self.pole.value() * (self.limits.target(command) - x[0]);
        let stop = self.limits.stop.value();
        if x[0] >= stop && rate > 0.0 {
            STOP_HIGH
        } else if x[0] <= -stop && rate < 0.0 {
            STOP_LOW
        } else if rate > self.limits.up.value() {
            RATE_UP
        } else if rate < -self.limits.down.value() {
            RATE_DOWN
        } else {
            FREE
        }
    }

    fn reset(&self, mode: usize, x: &mut [S; 1]) {
        match mode {
            STOP_HIGH => x[0] = self.limits.stop,
            STOP_LOW => x[0] = -self.limits.stop,
            _ => {}
        }
    }

    #[inline]
    fn output(&self, mode: usize, x: &[S; 1], command: f64) -> (S, f64, ActiveLimit) {
        let rate = match mode {
            FREE => self.pole.value() * (self.limits.target(command) - x[0].value()),
            RATE_UP => self.limits.up.value(),
            RATE_DOWN => -self.limits.down.value(),
            _ => 0.0,
        };
        (x[0], rate, limits::state(mode))
    }
}
