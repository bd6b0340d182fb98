//! Black box 2: `w' = A (gain c + offset - angle) - B w`, `angle' = w`, `w` a limited integrator,
//! as [`model_core::models::black_box_2`] steps it.

use std::sync::Arc;

use model_core::models::black_box_2::BlackBox2Parameters;
use model_core::parameter::Parameter;

use super::limits::{self, FREE, Limits, RATE_DOWN, RATE_UP, STOP_HIGH, STOP_LOW};
use super::tables::{InitialState, bounded, delay, rate_limit, row};
use super::{BlackBox1, Dynamics};
use crate::experiment::Experiment;
use crate::flow::{Face, Flow, System, Watch, drive};
use crate::model::{Description, Model, State};
use crate::scalar::Scalar;
use crate::start;

model_core::parameters! {
    /// The second-order black box as an oscillator: `A = wn^2`, `B = 2 zeta wn`.
    pub struct OscillatorParameters {
        /// Undamped natural frequency, `sqrt(A)`.
        natural_frequency_rad_s ["wn"]: 30.0, "rad/s", 0.1, 1e4, "paper, section III.B: A = 900";
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

/// Inner loop over pole where this model answers as the first-order one: its second pole is beyond
/// what shows, and still moves under a search.
const QUICK: f64 = 10.0;

/// The quickest pole that is taken over, rad/s: the lag of 5 ms that a quicker one has not is soon found in the delay, and
/// an inner loop ten times as quick could not be stepped.
const QUICKEST_POLE: f64 = 200.0;

/// Places of the parameters; the first two are A and B, or frequency and damping.
const DELAY: usize = 2;
const UP: usize = 3;
const DOWN: usize = 4;
const STOP: usize = 7;
const ANGLE: usize = 8;
const RATE: usize = 9;

impl BlackBox2 {
    /// The model with its gains in this form.
    pub fn new(form: Form) -> Self {
        type Table = BlackBox2Parameters;
        let [first, second] = match form {
            Form::Gains => [
                bounded::<Table>("position_gain_per_s2", 0.01, 1e8),
                bounded::<Table>("rate_gain_per_s", 0.01, 1e4),
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

impl Description for BlackBox2 {
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

    /// With an inner loop that is quick against the pole it is the first-order one.
    fn special_cases(&self) -> Vec<Arc<dyn Model>> {
        vec![Arc::new(BlackBox1::default())]
    }

    fn lifted(&self, parameter: usize, case: &dyn Model, values: &[f64]) -> Option<f64> {
        let named = |name: &str| case.parameters().iter().position(|p| p.name == name);
        let pole = named("pole_rad_s").map(|place| values[place].min(QUICKEST_POLE));
        match (parameter, pole, self.form) {
            (0, Some(pole), Form::Gains) => Some(QUICK * pole * pole),
            (1, Some(pole), Form::Gains) => Some(QUICK * pole),
            (0, Some(pole), Form::Oscillator) => Some(QUICK.sqrt() * pole),
            (1, Some(_), Form::Oscillator) => Some(0.5 * QUICK.sqrt()),
            _ => named(self.parameters[parameter].name).map(|place| values[place]),
        }
    }
}

impl Dynamics for BlackBox2 {
    #[inline(always)]
    fn run<S: Scalar>(&self, run: &Experiment, values: &[S], seen: &mut impl Watch<S>) {
        let (first, second) = (values[0], values[1]);
        let (position, rate) = match self.form {
            Form::Gains => (first, second),
            Form::Oscillator => (first * first, first * second * 2.0),
        };
        let lag = Lag {
            position,
            rate,
            limits: Limits::new(&values[UP..=STOP]),
        };
        let initial = [values[ANGLE], values[RATE]];
        drive(&lag, run, initial, values[DELAY], seen);
    }
}

struct Lag<S> {
    position: S,
    rate: S,
    limits: Limits<S>,
}

impl<S: Scalar> Lag<S> {
    /// `sign w'`.
    fn acceleration(&self, sign: f64) -> Face<S, 2> {
        let position = self.position * sign;
        Face {
            row: [-position, self.rate * -sign],
            command: position * self.limits.gain,
            constant: position * self.limits.offset,
            next: FREE,
        }
    }
}

impl<S: Scalar> Flow<S, 2> for Lag<S> {
    const MODES: usize = limits::MODES;

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
            system.b[1] = self.position * self.limits.gain;
            system.d[1] = self.position * self.limits.offset;
        }
        system
    }

    fn faces(&self, mode: usize) -> Vec<Face<S, 2>> {
        let (up, down) = (self.limits.up, self.limits.down);
        let mut faces = match mode {
            FREE => vec![
                Limits::face(1, -1.0, up, RATE_UP),
                Limits::face(1, 1.0, down, RATE_DOWN),
            ],
            RATE_UP => vec![self.acceleration(1.0)],
            RATE_DOWN => vec![self.acceleration(-1.0)],
            STOP_HIGH => return vec![self.acceleration(1.0)],
            _ => return vec![self.acceleration(-1.0)],
        };
        self.limits.stops(&mut faces);
        faces
    }

    fn mode_at(&self, &[angle, rate]: &[f64; 2], command: f64) -> usize {
        let limits = &self.limits;
        let far = limits.target(command) - angle;
        let acceleration = self.position.value() * far - self.rate.value() * rate;
        let stop = limits.stop.value();
        if angle >= stop && rate >= 0.0 && acceleration > 0.0 {
            STOP_HIGH
        } else if angle <= -stop && rate <= 0.0 && acceleration < 0.0 {
            STOP_LOW
        } else if rate >= limits.up.value() && acceleration > 0.0 {
            RATE_UP
        } else if rate <= -limits.down.value() && acceleration < 0.0 {
            RATE_DOWN
        } else {
            FREE
        }
    }

    fn enter(&self, mode: usize, x: &mut [S; 2]) {
        let still = S::constant(0.0);
        match mode {
            RATE_UP => x[1] = self.limits.up,
            RATE_DOWN => x[1] = -self.limits.down,
            STOP_HIGH => *x = [self.limits.stop, still],
            STOP_LOW => *x = [-self.limits.stop, still],
            _ => {}
        }
    }

    #[inline]
    fn seen(&self, mode: usize, x: &[S; 2], _command: f64) -> (S, f64, State) {
        (x[0], x[1].value(), limits::state(mode))
    }
}
