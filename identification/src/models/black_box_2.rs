//! Black box 2: `w' = A (gain c + offset - angle) - B w`, `angle' = w`, `w` a limited integrator,
//! as [`model_core::models::black_box_2`] steps it; by its gains, or by frequency and damping.

use std::sync::Arc;

use model_core::models::{SetupParameters, black_box_2::BlackBox2Parameters};
use model_core::parameter::Parameters;

use super::initial_state::InitialState;
use super::limits::{self, FREE, Limits, RATE_DOWN, RATE_UP, STOP_HIGH, STOP_LOW};
use super::{BlackBox1, Dynamics};
use crate::experiment::Experiment;
use crate::hybrid::{Guard, HybridModel, LinearSystem, Output, simulate};
use crate::model::{
    ActiveLimit, Description, Model, ModelParameter, NestedOptimum, ParameterValues, parameters,
};
use crate::scalar::Scalar;
use crate::start::DataSummary;

model_core::parameters! {
    /// The second-order black box as an oscillator: `A = wn^2`, `B = 2 zeta wn`.
    pub struct OscillatorParameters {
        /// Undamped natural frequency, `sqrt(A)`.
        natural_frequency_rad_s ["wn"]: 30.0, "rad/s", 0.1, 1e4, "paper, section III.B: A = 900";
        /// Damping ratio, `B/(2 sqrt(A))`.
        damping ["zeta"]: 0.9, "1", 0.01, 50.0, "paper, section III.B: A = 900, B = 54";
    }
}

/// Second-order lag with limits of rate and position, behind a delay, by the paper's gains A and B.
#[derive(Debug, Clone, Copy)]
pub struct BlackBox2;

/// The same model by natural frequency and damping.
#[derive(Debug, Clone, Copy)]
pub struct BlackBox2Oscillator;

parameters! {
    /// Parameters of [`BlackBox2`].
    pub struct BlackBox2Values {
        position_gain_per_s2: BlackBox2Parameters.within(0.01, 1e8);
        rate_gain_per_s: BlackBox2Parameters.within(0.01, 1e4);
        delay_s: SetupParameters;
        rate_limit_up_deg_s: BlackBox2Parameters.rate_limit();
        rate_limit_down_deg_s: BlackBox2Parameters.rate_limit();
        gain: BlackBox2Parameters.within(-20.0, 20.0);
        offset_deg: BlackBox2Parameters;
        position_limit_deg: BlackBox2Parameters.fixed();
        initial_angle_deg: InitialState.initial_state();
        initial_rate_deg_s: InitialState.initial_state().fixed();
    }
}

parameters! {
    /// Parameters of [`BlackBox2Oscillator`].
    pub struct OscillatorValues {
        natural_frequency_rad_s: OscillatorParameters;
        damping: OscillatorParameters;
        delay_s: SetupParameters;
        rate_limit_up_deg_s: BlackBox2Parameters.rate_limit();
        rate_limit_down_deg_s: BlackBox2Parameters.rate_limit();
        gain: BlackBox2Parameters.within(-20.0, 20.0);
        offset_deg: BlackBox2Parameters;
        position_limit_deg: BlackBox2Parameters.fixed();
        initial_angle_deg: InitialState.initial_state();
        initial_rate_deg_s: InitialState.initial_state().fixed();
    }
}

impl<S: Scalar> OscillatorValues<S> {
    /// The same by the gains.
    fn by_gains(&self) -> BlackBox2Values<S> {
        let (position_gain_per_s2, rate_gain_per_s) =
            gains(self.natural_frequency_rad_s, self.damping);
        BlackBox2Values {
            position_gain_per_s2,
            rate_gain_per_s,
            delay_s: self.delay_s,
            rate_limit_up_deg_s: self.rate_limit_up_deg_s,
            rate_limit_down_deg_s: self.rate_limit_down_deg_s,
            gain: self.gain,
            offset_deg: self.offset_deg,
            position_limit_deg: self.position_limit_deg,
            initial_angle_deg: self.initial_angle_deg,
            initial_rate_deg_s: self.initial_rate_deg_s,
        }
    }
}

/// The greatest gain of the inner loop that the simulator takes, 1/s.
const GREATEST_RATE_GAIN_PER_S: f64 = ModelParameter::of(
    <BlackBox2Parameters as Parameters>::TABLE,
    "rate_gain_per_s",
)
.parameter
.max;

/// The gains of an oscillator. Beyond the simulator's range of the inner loop's gain the damping
/// has no effect: no box of frequency and damping is that range.
pub fn gains<S: Scalar>(natural_frequency_rad_s: S, damping: S) -> (S, S) {
    let rate_gain = natural_frequency_rad_s * damping * 2.0;
    let greatest = S::constant(GREATEST_RATE_GAIN_PER_S);
    (
        natural_frequency_rad_s * natural_frequency_rad_s,
        rate_gain.within(S::constant(0.0), greatest),
    )
}

/// Ratio of the inner loop's bandwidth to the pole at which this model reproduces black box 1: the
/// second pole is too fast to show, and still has a sensitivity.
const INNER_LOOP_RATIO: f64 = 10.0;

/// The fastest pole that is taken from black box 1, rad/s: the lag of 5 ms that a faster one lacks
/// is found in the delay, and an inner loop ten times as fast could not be simulated.
const FASTEST_POLE_RAD_S: f64 = 200.0;

/// The pole of a first-order optimum; `None` where the nested model has no pole.
fn nested_pole(nested: &NestedOptimum<'_>) -> Option<f64> {
    Some(nested.value("pole_rad_s")?.min(FASTEST_POLE_RAD_S))
}

pub(super) fn models() -> Vec<Arc<dyn Model>> {
    vec![Arc::new(BlackBox2), Arc::new(BlackBox2Oscillator)]
}

impl Description for BlackBox2 {
    fn name(&self) -> &'static str {
        "black-box-2"
    }

    fn summary(&self) -> &'static str {
        "second-order lag with delay, rate and position limits"
    }

    fn parameters(&self) -> &[ModelParameter] {
        BlackBox2Values::<f64>::TABLE
    }

    /// With an inner loop that is fast against the pole it approaches black box 1.
    fn nested_models(&self) -> Vec<Arc<dyn Model>> {
        vec![Arc::new(BlackBox1)]
    }

    fn value_from_nested(&self, name: &str, nested: &NestedOptimum<'_>) -> Option<f64> {
        match (name, nested_pole(nested)) {
            ("position_gain_per_s2", Some(pole)) => Some(INNER_LOOP_RATIO * pole * pole),
            ("rate_gain_per_s", Some(pole)) => Some(INNER_LOOP_RATIO * pole),
            _ => nested.value(name),
        }
    }
}

impl Dynamics for BlackBox2 {
    type Parameters<S: Scalar> = BlackBox2Values<S>;

    fn start(&self, experiments: &[Experiment]) -> BlackBox2Values<f64> {
        BlackBox2Oscillator.start(experiments).by_gains()
    }

    #[inline(always)]
    fn run<S: Scalar>(
        &self,
        run: &Experiment,
        p: &BlackBox2Values<S>,
        output: &mut impl Output<S>,
    ) {
        let lag = Lag {
            position: p.position_gain_per_s2,
            rate: p.rate_gain_per_s,
            limits: Limits {
                up: p.rate_limit_up_deg_s,
                down: p.rate_limit_down_deg_s,
                gain: p.gain,
                offset: p.offset_deg,
                stop: p.position_limit_deg,
            },
        };
        let initial = [p.initial_angle_deg, p.initial_rate_deg_s];
        simulate(&lag, run, initial, p.delay_s, output);
    }
}

impl Description for BlackBox2Oscillator {
    fn name(&self) -> &'static str {
        "black-box-2-oscillator"
    }

    fn summary(&self) -> &'static str {
        "the same by natural frequency and damping"
    }

    fn parameters(&self) -> &[ModelParameter] {
        OscillatorValues::<f64>::TABLE
    }

    fn nested_models(&self) -> Vec<Arc<dyn Model>> {
        vec![Arc::new(BlackBox1)]
    }

    fn value_from_nested(&self, name: &str, nested: &NestedOptimum<'_>) -> Option<f64> {
        match (name, nested_pole(nested)) {
            ("natural_frequency_rad_s", Some(pole)) => Some(INNER_LOOP_RATIO.sqrt() * pole),
            ("damping", Some(_)) => Some(0.5 * INNER_LOOP_RATIO.sqrt()),
            _ => nested.value(name),
        }
    }
}

impl Dynamics for BlackBox2Oscillator {
    type Parameters<S: Scalar> = OscillatorValues<S>;

    fn start(&self, experiments: &[Experiment]) -> OscillatorValues<f64> {
        let data = DataSummary::of(experiments);
        OscillatorValues {
            natural_frequency_rad_s: data.natural_frequency_rad_s,
            damping: data.damping,
            delay_s: data.second_order_delay_s,
            rate_limit_up_deg_s: data.rate_up_deg_s,
            rate_limit_down_deg_s: data.rate_down_deg_s,
            gain: data.gain,
            offset_deg: data.offset_deg,
            position_limit_deg: f64::INFINITY,
            initial_angle_deg: data.initial_angle_deg,
            initial_rate_deg_s: data.initial_rate_deg_s,
        }
    }

    #[inline(always)]
    fn run<S: Scalar>(
        &self,
        run: &Experiment,
        p: &OscillatorValues<S>,
        output: &mut impl Output<S>,
    ) {
        BlackBox2.run(run, &p.by_gains(), output);
    }
}

struct Lag<S> {
    position: S,
    rate: S,
    limits: Limits<S>,
}

impl<S: Scalar> Lag<S> {
    /// `sign w'`.
    fn acceleration(&self, sign: f64) -> Guard<S, 2> {
        let position = self.position * sign;
        Guard {
            row: [-position, self.rate * -sign],
            command: position * self.limits.gain,
            constant: position * self.limits.offset,
            next: FREE,
        }
    }
}

impl<S: Scalar> HybridModel<S, 2> for Lag<S> {
    const MODES: usize = limits::MODES;

    fn system(&self, mode: usize) -> LinearSystem<S, 2> {
        let (zero, one) = (S::constant(0.0), S::constant(1.0));
        let mut system = LinearSystem {
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

    fn guards(&self, mode: usize) -> Vec<Guard<S, 2>> {
        let (up, down) = (self.limits.up, self.limits.down);
        let mut guards = match mode {
            FREE => vec![
                Limits::guard(1, -1.0, up, RATE_UP),
                Limits::guard(1, 1.0, down, RATE_DOWN),
            ],
            RATE_UP => vec![self.acceleration(1.0)],
            RATE_DOWN => vec![self.acceleration(-1.0)],
            STOP_HIGH => return vec![self.acceleration(1.0)],
            _ => return vec![self.acceleration(-1.0)],
        };
        self.limits.stops(&mut guards);
        guards
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

    fn reset(&self, mode: usize, x: &mut [S; 2]) {
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
    fn output(&self, mode: usize, x: &[S; 2], _command: f64) -> (S, f64, ActiveLimit) {
        (x[0], x[1].value(), limits::state(mode))
    }
}
