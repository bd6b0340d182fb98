//! Black box 2: `w' = A (gain c + offset - angle) - B w`, `angle' = w`, `w` a limited integrator,
//! as [`model_core::models::black_box_2`] steps it.

use model_core::models::black_box_2::BlackBox2Parameters;
use model_core::parameter::Parameter;

use super::tables::{InitialState, bounded, delay, rate_limit, row};
use super::{Dynamics, RecordingError};
use crate::identify::experiment::Experiment;
use crate::identify::flow::{Face, Flow, System, drive};
use crate::identify::model::State;
use crate::identify::recording::Recording;
use crate::identify::scalar::Scalar;
use crate::identify::start;

model_core::parameters! {
    /// The second-order black box as an oscillator: `A = wn^2`, `B = 2 zeta wn`.
    pub struct OscillatorParameters {
        /// Undamped natural frequency, `sqrt(A)`.
        natural_frequency_rad_s ["wn"]: 30.0, "rad/s", 0.1, 1000.0, "paper, section III.B: A = 900";
        /// Damping ratio, `B/(2 sqrt(A))`.
        damping ["zeta"]: 0.9, "1", 0.01, 50.0, "paper, section III.B: A = 900, B = 54";
    }
}

/// How the two gains are told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// As the paper's gains A and B.
    Gains,
    /// As natural frequency and damping.
    Oscillator,
}

/// Second-order lag with limits of rate and position, behind a delay.
#[derive(Debug, Clone)]
pub struct BlackBox2 {
    form: Form,
    parameters: Vec<Parameter>,
}

/// Places of the parameters; the first two are A and B, or frequency and damping.
const DELAY: usize = 2;
const UP: usize = 3;
const DOWN: usize = 4;
const GAIN: usize = 5;
const OFFSET: usize = 6;
const STOP: usize = 7;
const ANGLE: usize = 8;
const RATE: usize = 9;

impl BlackBox2 {
    /// The model with its gains in this form.
    pub fn new(form: Form) -> Self {
        type Table = BlackBox2Parameters;
        let [first, second] = match form {
            Form::Gains => [
                bounded::<Table>("position_gain_per_s2", 0.01, 1e6),
                bounded::<Table>("rate_gain_per_s", 0.01, 2000.0),
            ],
            Form::Oscillator => {
                ["natural_frequency_rad_s", "damping"].map(row::<OscillatorParameters>)
            }
        };
        Self {
            form,
            parameters: vec![
                first,
                second,
                delay(),
                rate_limit::<Table>("rate_limit_up_deg_s"),
                rate_limit::<Table>("rate_limit_down_deg_s"),
                bounded::<Table>("gain", -20.0, 20.0),
                row::<Table>("offset_deg"),
                row::<Table>("position_limit_deg"),
                row::<InitialState>("initial_angle_deg"),
                row::<InitialState>("initial_rate_deg_s"),
            ],
        }
    }
}

impl Dynamics for BlackBox2 {
    fn name(&self) -> &'static str {
        match self.form {
            Form::Gains => "black-box-2",
            Form::Oscillator => "black-box-2-oscillator",
        }
    }

    fn summary(&self) -> &'static str {
        match self.form {
            Form::Gains => "second-order lag with delay, rate and position limits",
            Form::Oscillator => "the same, told by natural frequency and damping",
        }
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn is_of_the_run(&self, parameter: usize) -> bool {
        parameter >= ANGLE
    }

    fn is_fixed_by_default(&self, parameter: usize) -> bool {
        parameter == STOP || parameter == RATE
    }

    fn is_limit(&self, parameter: usize) -> bool {
        matches!(parameter, UP | DOWN)
    }

    fn accepts(&self, _recording: &Recording) -> Result<(), RecordingError> {
        Ok(())
    }

    fn start(&self, experiments: &[Experiment]) -> Vec<f64> {
        let look = start::look(experiments);
        let (frequency, damping) = (look.natural_frequency_rad_s, look.damping);
        let [first, second] = match self.form {
            Form::Gains => [frequency * frequency, 2.0 * damping * frequency],
            Form::Oscillator => [frequency, damping],
        };
        vec![
            first,
            second,
            look.second_order_delay_s,
            look.rate_up_deg_s,
            look.rate_down_deg_s,
            look.gain,
            look.offset_deg,
            f64::INFINITY,
            look.initial_angle_deg,
            look.initial_rate_deg_s,
        ]
    }

    fn run<S: Scalar>(
        &self,
        run: &Experiment,
        values: &[S],
        seen: &mut impl FnMut(usize, S, f64, State),
    ) {
        let (first, second) = (values[0], values[1]);
        let (position, rate) = match self.form {
            Form::Gains => (first, second),
            Form::Oscillator => (first * first, first * second * 2.0),
        };
        let lag = Lag {
            position,
            rate,
            up: values[UP],
            down: values[DOWN],
            gain: values[GAIN],
            offset: values[OFFSET],
            stop: values[STOP],
        };
        let initial = [values[ANGLE], values[RATE]];
        drive(&lag, run, initial, values[DELAY], seen);
    }
}

struct Lag<S> {
    position: S,
    rate: S,
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
    /// `sign w'`.
    fn acceleration(&self, sign: f64) -> Face<S, 2> {
        let position = self.position * sign;
        Face {
            row: [-position, self.rate * -sign],
            command: position * self.gain,
            constant: position * self.offset,
            next: FREE,
        }
    }

    /// `sign x[state] + limit`.
    fn limit(state: usize, sign: f64, limit: S, next: usize) -> Face<S, 2> {
        let mut row = [S::constant(0.0); 2];
        row[state] = S::constant(sign);
        Face {
            row,
            command: S::constant(0.0),
            constant: limit,
            next,
        }
    }
}

impl<S: Scalar> Flow<S, 2> for Lag<S> {
    const MODES: usize = 5;

    fn system(&self, mode: usize) -> System<S, 2> {
        let (zero, one) = (S::constant(0.0), S::constant(1.0));
        let mut system = System {
            a: [[zero; 2]; 2],
            b: [zero; 2],
            d: [zero; 2],
        };
        if mode <= RATE_DOWN {
            system.a[0][1] = one;
        }
        if mode == FREE {
            system.a[1] = [-self.position, -self.rate];
            system.b[1] = self.position * self.gain;
            system.d[1] = self.position * self.offset;
        }
        system
    }

    fn faces(&self, mode: usize) -> Vec<Face<S, 2>> {
        let mut faces = match mode {
            FREE => vec![
                Self::limit(1, -1.0, self.up, RATE_UP),
                Self::limit(1, 1.0, self.down, RATE_DOWN),
            ],
            RATE_UP => vec![self.acceleration(1.0)],
            RATE_DOWN => vec![self.acceleration(-1.0)],
            STOP_HIGH => return vec![self.acceleration(1.0)],
            _ => return vec![self.acceleration(-1.0)],
        };
        if self.stop.value().is_finite() {
            faces.push(Self::limit(0, -1.0, self.stop, STOP_HIGH));
            faces.push(Self::limit(0, 1.0, self.stop, STOP_LOW));
        }
        faces
    }

    fn mode_at(&self, &[angle, rate]: &[f64; 2], command: f64) -> usize {
        let target = self.gain.value() * command + self.offset.value();
        let acceleration = self.position.value() * (target - angle) - self.rate.value() * rate;
        let stop = self.stop.value();
        if angle >= stop && rate >= 0.0 && acceleration > 0.0 {
            STOP_HIGH
        } else if angle <= -stop && rate <= 0.0 && acceleration < 0.0 {
            STOP_LOW
        } else if rate >= self.up.value() && acceleration > 0.0 {
            RATE_UP
        } else if rate <= -self.down.value() && acceleration < 0.0 {
            RATE_DOWN
        } else {
            FREE
        }
    }

    fn enter(&self, mode: usize, x: &mut [S; 2]) {
        match mode {
            RATE_UP => x[1] = self.up,
            RATE_DOWN => x[1] = -self.down,
            STOP_HIGH => *x = [self.stop, S::constant(0.0)],
            STOP_LOW => *x = [-self.stop, S::constant(0.0)],
            _ => {}
        }
    }

    fn seen(&self, mode: usize, x: &[S; 2], _command: f64) -> (S, f64, State) {
        let state = match mode {
            FREE => State::Free,
            RATE_UP => State::RateUp,
            RATE_DOWN => State::RateDown,
            _ => State::Stop,
        };
        (x[0], x[1].value(), state)
    }
}
