//! Black box 1: `angle' = sat(p (gain c + offset - angle))`, as [`model_core::models::black_box_1`]
//! steps it.

use model_core::models::black_box_1::BlackBox1Parameters;
use model_core::parameter::Parameter;

use super::Dynamics;
use super::limits::{self, FREE, Limits, RATE_DOWN, RATE_UP, STOP_HIGH, STOP_LOW};
use super::tables::{InitialState, bounded, delay, rate_limit, row};
use crate::experiment::Experiment;
use crate::flow::{Face, Flow, System, Watch, drive};
use crate::model::{Description, State};
use crate::scalar::Scalar;
use crate::start;

/// First-order lag with limits of rate and position, behind a delay.
#[derive(Debug, Clone)]
pub struct BlackBox1 {
    parameters: Vec<Parameter>,
}

/// Places of the parameters.
const POLE: usize = 0;
const DELAY: usize = 1;
const UP: usize = 2;
const DOWN: usize = 3;
const STOP: usize = 6;
const ANGLE: usize = 7;

impl Default for BlackBox1 {
    fn default() -> Self {
        type Table = BlackBox1Parameters;
        Self {
            parameters: vec![
                bounded::<Table>("pole_rad_s", 0.05, 1000.0),
                delay(),
                rate_limit::<Table>("rate_limit_up_deg_s"),
                rate_limit::<Table>("rate_limit_down_deg_s"),
                bounded::<Table>("gain", -20.0, 20.0),
                row::<Table>("offset_deg"),
                row::<Table>("position_limit_deg"),
                row::<InitialState>("initial_angle_deg"),
            ],
        }
    }
}

impl Description for BlackBox1 {
    fn name(&self) -> &'static str {
        "black-box-1"
    }

    fn summary(&self) -> &'static str {
        "first-order lag with delay, rate and position limits"
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn is_of_the_run(&self, parameter: usize) -> bool {
        parameter == ANGLE
    }

    fn is_fixed_by_default(&self, parameter: usize) -> bool {
        parameter == STOP
    }

    fn is_limit(&self, parameter: usize) -> bool {
        matches!(parameter, UP | DOWN)
    }

    fn start(&self, experiments: &[Experiment]) -> Vec<f64> {
        let look = start::look(experiments);
        vec![
            look.pole_rad_s,
            look.delay_s,
            look.rate_up_deg_s,
            look.rate_down_deg_s,
            look.gain,
            look.offset_deg,
            f64::INFINITY,
            look.initial_angle_deg,
        ]
    }
}

impl Dynamics for BlackBox1 {
    #[inline(always)]
    fn run<S: Scalar>(&self, run: &Experiment, values: &[S], seen: &mut impl Watch<S>) {
        let lag = Lag {
            pole: values[POLE],
            limits: Limits::new(&values[UP..=STOP]),
        };
        drive(&lag, run, [values[ANGLE]], values[DELAY], seen);
    }
}

struct Lag<S> {
    pole: S,
    limits: Limits<S>,
}

impl<S: Scalar> Lag<S> {
    /// `sign (p (target - angle)) + more`.
    fn rate(&self, sign: f64, more: S, next: usize) -> Face<S, 1> {
        let pole = self.pole * sign;
        Face {
            row: [-pole],
            command: pole * self.limits.gain,
            constant: pole * self.limits.offset + more,
            next,
        }
    }
}

impl<S: Scalar> Flow<S, 1> for Lag<S> {
    const MODES: usize = limits::MODES;

    fn system(&self, mode: usize) -> System<S, 1> {
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
        System {
            a: [[a]],
            b: [b],
            d: [d],
        }
    }

    fn faces(&self, mode: usize) -> Vec<Face<S, 1>> {
        let zero = S::constant(0.0);
        let (up, down) = (self.limits.up, self.limits.down);
        let mut faces = match mode {
            FREE => vec![
                self.rate(-1.0, up, RATE_UP),
                self.rate(1.0, down, RATE_DOWN),
            ],
            RATE_UP => vec![self.rate(1.0, -up, FREE)],
            RATE_DOWN => vec![self.rate(-1.0, -down, FREE)],
            STOP_HIGH => return vec![self.rate(1.0, zero, FREE)],
            _ => return vec![self.rate(-1.0, zero, FREE)],
        };
        self.limits.stops(&mut faces);
        faces
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

    fn enter(&self, mode: usize, x: &mut [S; 1]) {
        match mode {
            STOP_HIGH => x[0] = self.limits.stop,
            STOP_LOW => x[0] = -self.limits.stop,
            _ => {}
        }
    }

    #[inline]
    fn seen(&self, mode: usize, x: &[S; 1], command: f64) -> (S, f64, State) {
        let rate = match mode {
            FREE => self.pole.value() * (self.limits.target(command) - x[0].value()),
            RATE_UP => self.limits.up.value(),
            RATE_DOWN => -self.limits.down.value(),
            _ => 0.0,
        };
        (x[0], rate, limits::state(mode))
    }
}
