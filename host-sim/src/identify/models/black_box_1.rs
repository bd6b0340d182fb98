//! Black box 1: `angle' = sat(p (gain c + offset - angle))`, as [`model_core::models::black_box_1`]
//! steps it.

use model_core::models::black_box_1::BlackBox1Parameters;
use model_core::parameter::Parameter;

use super::tables::{InitialState, bounded, delay, rate_limit, row};
use super::{Dynamics, RecordingError};
use crate::identify::experiment::Experiment;
use crate::identify::flow::{Face, Flow, System, drive};
use crate::identify::model::State;
use crate::identify::recording::Recording;
use crate::identify::scalar::Scalar;
use crate::identify::start;

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
const GAIN: usize = 4;
const OFFSET: usize = 5;
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

impl Dynamics for BlackBox1 {
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

    fn accepts(&self, _recording: &Recording) -> Result<(), RecordingError> {
        Ok(())
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

    fn run<S: Scalar>(
        &self,
        run: &Experiment,
        values: &[S],
        seen: &mut impl FnMut(usize, S, f64, State),
    ) {
        let lag = Lag {
            pole: values[POLE],
            up: values[UP],
            down: values[DOWN],
            gain: values[GAIN],
            offset: values[OFFSET],
            stop: values[STOP],
        };
        drive(&lag, run, [values[ANGLE]], values[DELAY], seen);
    }
}

struct Lag<S> {
    pole: S,
    up: S,
    down: S,
    gain: S,
    offset: S,
    stop: S,
}

const FREE: usize = 0;
const RATE_UP: usize = 1;
const RATE_DOWN: usize = 2;
const STOP_HIGH: usize = 3;
const STOP_LOW: usize = 4;

impl<S: Scalar> Lag<S> {
    /// `sign (p (target - angle)) + more`.
    fn rate(&self, sign: f64, more: S, next: usize) -> Face<S, 1> {
        let pole = self.pole * sign;
        Face {
            row: [-pole],
            command: pole * self.gain,
            constant: pole * self.offset + more,
            next,
        }
    }

    fn stops(&self, faces: &mut Vec<Face<S, 1>>) {
        if self.stop.value().is_finite() {
            faces.extend(
                [(-1.0, STOP_HIGH), (1.0, STOP_LOW)].map(|(sign, next)| Face {
                    row: [S::constant(sign)],
                    command: S::constant(0.0),
                    constant: self.stop,
                    next,
                }),
            );
        }
    }
}

impl<S: Scalar> Flow<S, 1> for Lag<S> {
    const MODES: usize = 5;

    fn system(&self, mode: usize) -> System<S, 1> {
        let zero = S::constant(0.0);
        let (a, b, d) = match mode {
            FREE => (-self.pole, self.pole * self.gain, self.pole * self.offset),
            RATE_UP => (zero, zero, self.up),
            RATE_DOWN => (zero, zero, -self.down),
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
        let mut faces = match mode {
            FREE => vec![
                self.rate(-1.0, self.up, RATE_UP),
                self.rate(1.0, self.down, RATE_DOWN),
            ],
            RATE_UP => vec![self.rate(1.0, -self.up, FREE)],
            RATE_DOWN => vec![self.rate(-1.0, -self.down, FREE)],
            STOP_HIGH => return vec![self.rate(1.0, zero, FREE)],
            _ => return vec![self.rate(-1.0, zero, FREE)],
        };
        self.stops(&mut faces);
        faces
    }

    fn mode_at(&self, x: &[f64; 1], command: f64) -> usize {
        let target = self.gain.value() * command + self.offset.value();
        let rate = self.pole.value() * (target - x[0]);
        let stop = self.stop.value();
        if x[0] >= stop && rate > 0.0 {
            STOP_HIGH
        } else if x[0] <= -stop && rate < 0.0 {
            STOP_LOW
        } else if rate > self.up.value() {
            RATE_UP
        } else if rate < -self.down.value() {
            RATE_DOWN
        } else {
            FREE
        }
    }

    fn enter(&self, mode: usize, x: &mut [S; 1]) {
        match mode {
            STOP_HIGH => x[0] = self.stop,
            STOP_LOW => x[0] = -self.stop,
            _ => {}
        }
    }

    fn seen(&self, mode: usize, x: &[S; 1], command: f64) -> (S, f64, State) {
        let target = self.gain.value() * command + self.offset.value();
        let (rate, state) = match mode {
            FREE => (self.pole.value() * (target - x[0].value()), State::Free),
            RATE_UP => (self.up.value(), State::RateUp),
            RATE_DOWN => (-self.down.value(), State::RateDown),
            _ => (0.0, State::Stop),
        };
        (x[0], rate, state)
    }
}
