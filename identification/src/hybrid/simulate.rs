//! Simulates a model at the samples of a recording, with a delayed command.

use super::propagator::Caching;
use super::simulator::HybridSimulator;
use super::{Command, HybridModel};
use crate::command::Segment;
use crate::experiment::Experiment;
use crate::model::ActiveLimit;
use crate::scalar::Scalar;

/// The end of a step: a sample, or the arrival of a segment of the command.
#[derive(Clone, Copy)]
struct StepEnd {
    time_ns: i64,
    is_arrival: bool,
}

/// Takes the output of a model, sample after sample.
pub trait Output<S> {
    /// Number of the sample, angle in deg, rate in deg/s, and the active limit.
    fn sample(&mut self, i: usize, angle_deg: S, rate_deg_s: f64, state: ActiveLimit);
}

impl<S, F: FnMut(usize, S, f64, ActiveLimit)> Output<S> for F {
    #[inline(always)]
    fn sample(&mut self, i: usize, angle_deg: S, rate_deg_s: f64, state: ActiveLimit) {
        self(i, angle_deg, rate_deg_s, state);
    }
}

/// A model that is stepped under a command.
pub trait Stepper<S: Scalar> {
    /// Whether it describes the motion while the motor is off.
    const MODELS_MOTOR_OFF: bool;

    /// Switches the motor on or off; `angle_deg` is the last measured angle.
    fn switch_motor(&mut self, is_on: bool, angle_deg: f64, command: f64);

    /// Advances by `step`; `caching` selects how the results for its length are cached.
    fn advance(&mut self, step: S, caching: Caching, command: &Command<S>);

    /// Repeats the last step, of a length that depends on no parameter and under a constant
    /// command, from the cache. Returns whether it could.
    fn repeat_step(&mut self, _step_s: f64, _command: f64) -> bool {
        false
    }

    /// Takes note that the command has jumped to this value.
    fn command_jumped(&mut self, command: f64);

    /// Angle, rate and active limit under a command.
    fn output(&self, command: f64) -> (S, f64, ActiveLimit);
}

impl<S: Scalar, const N: usize, F: HybridModel<S, N>> Stepper<S> for HybridSimulator<'_, F, S, N> {
    const MODELS_MOTOR_OFF: bool = false;

    fn switch_motor(&mut self, is_on: bool, angle_deg: f64, command: f64) {
        HybridSimulator::switch_motor(self, is_on, angle_deg, command);
    }

    fn advance(&mut self, step: S, caching: Caching, command: &Command<S>) {
        HybridSimulator::advance(self, step, caching, command);
    }

    #[inline(always)]
    fn repeat_step(&mut self, step_s: f64, command: f64) -> bool {
        HybridSimulator::repeat_step(self, step_s, command)
    }

    fn command_jumped(&mut self, command: f64) {
        self.select_mode(command);
    }

    #[inline(always)]
    fn output(&self, command: f64) -> (S, f64, ActiveLimit) {
        self.model.output(self.mode, &self.x, command)
    }
}

/// Simulates a run of a hybrid system from the state `x` at the first sample.
#[inline(always)]
pub fn simulate<S: Scalar, const N: usize, F: HybridModel<S, N>>(
    model: &F,
    run: &Experiment,
    x: [S; N],
    delay: S,
    output: &mut impl Output<S>,
) {
    let before = run.command.first().map_or(0.0, |s| s.q[0]);
    let mut simulator = HybridSimulator::new(model, x, before);
    simulate_steps(&mut simulator, run, &run.command, delay, output);
}

/// Steps a model along a run under these segments of the command, and passes angle, rate and active
/// limit of each sample to `output`. Before the first sample the command has its first value, or
/// the actuator is at rest until that arrives.
///
/// The delay is exact, also where it is no multiple of a sample: the steps end where the delayed
/// command changes and where the angle was sampled, so that nothing is interpolated.
#[inline(always)]
pub fn simulate_steps<S: Scalar, R: Stepper<S>>(
    simulator: &mut R,
    run: &Experiment,
    segments: &[Segment],
    delay: S,
    output: &mut impl Output<S>,
) {
    let first = segments.first();
    let before = first.map_or(0.0, |s| s.q[0]);
    let mut segment: Option<&Segment> = None;
    let mut upcoming = segments.iter().peekable();
    let mut place = StepEnd {
        time_ns: 0,
        is_arrival: false,
    };
    let rests = |segment: Option<&Segment>| run.begins_at_rest && segment.is_none();
    let motor_on = run.recording.motor_on.as_deref();
    let mut is_on = true;
    for (i, &time_ns) in run.time_ns.iter().enumerate() {
        let sample = StepEnd {
            time_ns,
            is_arrival: false,
        };
        while let Some(next) =
            upcoming.next_if(|s| seconds(s.start_ns - time_ns) + delay.value() <= 0.0)
        {
            let arrival = StepEnd {
                time_ns: next.start_ns,
                is_arrival: true,
            };
            let was_at_rest = rests(segment);
            if (is_on || R::MODELS_MOTOR_OFF) && !was_at_rest {
                step(simulator, run, (segment, first), (place, arrival), delay);
            }
            (place, segment) = (arrival, Some(next));
            if next.jumps || was_at_rest {
                simulator.command_jumped(next.q[0]);
            }
        }
        let constant = match segment {
            None => Some(before),
            Some(s) => s.is_constant.then_some(s.q[0]),
        };
        let is_variable = segment.or(first).is_some_and(|s| s.variable.is_some());
        if i > 0 && (is_on || R::MODELS_MOTOR_OFF) && !rests(segment) {
            let is_along = run.is_even && !place.is_arrival && !is_variable;
            let step_s = seconds(time_ns - place.time_ns);
            if !(is_along && constant.is_some_and(|c| simulator.repeat_step(step_s, c))) {
                step(simulator, run, (segment, first), (place, sample), delay);
            }
        }
        if i > 0 {
            place = sample;
        }
        let level = constant.unwrap_or_else(|| {
            let since = |s: &Segment| s.after(seconds(time_ns - s.start_ns) - delay.value());
            segment.map_or(before, since)
        });
        if motor_on.is_some_and(|on| !on[i].is_nan() && (on[i] != 0.0) != is_on) {
            is_on = !is_on;
            simulator.switch_motor(is_on, measured(run, i), level);
        }
        if !(is_on || R::MODELS_MOTOR_OFF) {
            output.sample(i, S::constant(f64::NAN), f64::NAN, ActiveLimit::Off);
            continue;
        }
        match simulator.output(level) {
            (angle, ..) if rests(segment) => output.sample(i, angle, 0.0, ActiveLimit::Free),
            (angle, rate, state) => output.sample(i, angle, rate, state),
        }
    }
}

/// The last measured angle up to sample `i`, deg; NaN without one, and at the first sample.
#[cold]
fn measured(run: &Experiment, i: usize) -> f64 {
    if i == 0 {
        return f64::NAN;
    }
    let angles = run.recording.angle_deg[..=i].iter().rev();
    angles.copied().find(|a| !a.is_nan()).unwrap_or(f64::NAN)
}

/// The level with which a segment starts, and its derivative by itself.
#[inline(always)]
fn level<S: Scalar>(segment: &Segment) -> Command<S> {
    let level = segment.q[0];
    match segment.variable {
        None => Command::Constant(level),
        Some(index) => {
            let zero = S::constant(0.0);
            Command::Cubic([S::variable(level, index), zero, zero, zero])
        }
    }
}

#[inline(always)]
fn seconds(time_ns: i64) -> f64 {
    time_ns as f64 * 1e-9
}

/// With so few segments the steps to and from their arrivals are not worth caching.
const FEW_SEGMENTS: usize = 16;

/// One step between two instants under a segment of the command, or under the level of the first
/// one before that arrives.
fn step<S: Scalar>(
    simulator: &mut impl Stepper<S>,
    run: &Experiment,
    (segment, first): (Option<&Segment>, Option<&Segment>),
    (from, to): (StepEnd, StepEnd),
    delay: S,
) {
    let length = S::constant(seconds(to.time_ns - from.time_ns));
    let (length, side) = match (from.is_arrival, to.is_arrival) {
        (true, false) => (length - delay, -1),
        (false, true) => (length + delay, 1),
        _ => (length, 0),
    };
    let command = match segment {
        None => first.map_or(Command::Constant(0.0), level),
        Some(s) if s.is_constant => level(s),
        Some(s) => {
            let start = Command::Cubic(s.q.map(S::constant));
            if from.is_arrival {
                start
            } else {
                let since = S::constant(seconds(from.time_ns - s.start_ns)) - delay;
                start.later(since)
            }
        }
    };
    let is_repeated = side == 0 || run.command.len() > FEW_SEGMENTS;
    let caching = if run.is_even && is_repeated {
        Caching::Keyed(side)
    } else {
        Caching::Off
    };
    simulator.advance(length, caching, &command);
}
