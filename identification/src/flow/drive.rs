//! A model along the samples of a recording, behind a delay.

use super::propagator::Kept;
use super::runner::Runner;
use super::{Command, Flow};
use crate::command::Segment;
use crate::experiment::Experiment;
use crate::model::State;
use crate::scalar::Scalar;

/// Where the last step ended: at a sample, or where a segment of the command arrived.
#[derive(Clone, Copy)]
struct Place {
    time_ns: i64,
    is_arrival: bool,
}

/// Takes what is seen of a model, sample after sample.
pub trait Watch<S> {
    /// Number of the sample, angle in deg, rate in deg/s, and what limits it.
    fn see(&mut self, i: usize, angle_deg: S, rate_deg_s: f64, state: State);
}

impl<S, F: FnMut(usize, S, f64, State)> Watch<S> for F {
    #[inline(always)]
    fn see(&mut self, i: usize, angle_deg: S, rate_deg_s: f64, state: State) {
        self(i, angle_deg, rate_deg_s, state);
    }
}

/// Something that moves under a command.
pub trait Steps<S: Scalar> {
    /// Whether it is known how it moves while the motor is off.
    const MOVES_ALONE: bool;

    /// The motor is switched on or off under a command, the last measured angle being this, deg.
    fn switch(&mut self, is_on: bool, angle_deg: f64, command: f64);

    /// Moves through `step`; `kept` is how to keep what is computed for its length.
    fn advance(&mut self, step: S, kept: Kept, command: &Command<S>);

    /// Moves through a step of a length that depends on no parameter, under a command that stands
    /// still, if there is a short way: it says whether there was.
    fn glide(&mut self, _step_s: f64, _command: f64) -> bool {
        false
    }

    /// The command jumps to this value.
    fn jump(&mut self, command: f64);

    /// Angle, rate and limit that are seen under a command.
    fn seen(&self, command: f64) -> (S, f64, State);
}

impl<S: Scalar, const N: usize, F: Flow<S, N>> Steps<S> for Runner<'_, F, S, N> {
    const MOVES_ALONE: bool = false;

    fn switch(&mut self, is_on: bool, angle_deg: f64, command: f64) {
        Runner::switch(self, is_on, angle_deg, command);
    }

    fn advance(&mut self, step: S, kept: Kept, command: &Command<S>) {
        Runner::advance(self, step, kept, command);
    }

    #[inline(always)]
    fn glide(&mut self, step_s: f64, command: f64) -> bool {
        Runner::glide(self, step_s, command)
    }

    fn jump(&mut self, command: f64) {
        self.decide(command);
    }

    #[inline(always)]
    fn seen(&self, command: f64) -> (S, f64, State) {
        self.flow.seen(self.mode, &self.x, command)
    }
}

/// Simulates a run of a model that is linear between its limits, from the state `x` at the first
/// sample.
#[inline(always)]
pub fn drive<S: Scalar, const N: usize, F: Flow<S, N>>(
    flow: &F,
    run: &Experiment,
    x: [S; N],
    delay: S,
    seen: &mut impl Watch<S>,
) {
    let before = run.command.first().map_or(0.0, |s| s.q[0]);
    let mut runner = Runner::new(flow, x, before);
    drive_steps(&mut runner, run, &run.command, delay, seen);
}

/// Moves something along a run under these segments of command, and hands out angle, rate and limit
/// at each sample. Before the first sample the command is what it is there, or all is at rest until it
/// arrives.
///
/// The delay is exact, whatever its fraction of a sample: the steps end where the delayed command
/// changes and where the angle was sampled, so that nothing is interpolated.
#[inline(always)]
pub fn drive_steps<S: Scalar, R: Steps<S>>(
    runner: &mut R,
    run: &Experiment,
    segments: &[Segment],
    delay: S,
    seen: &mut impl Watch<S>,
) {
    let before = segments.first().map_or(0.0, |s| s.q[0]);
    let mut segment: Option<&Segment> = None;
    let mut upcoming = segments.iter().peekable();
    let mut place = Place {
        time_ns: 0,
        is_arrival: false,
    };
    let rests = |segment: Option<&Segment>| run.begins_at_rest && segment.is_none();
    let motor_on = run.recording.motor_on.as_deref();
    let mut is_on = true;
    for (i, &time_ns) in run.time_ns.iter().enumerate() {
        let sample = Place {
            time_ns,
            is_arrival: false,
        };
        while let Some(next) =
            upcoming.next_if(|s| seconds(s.start_ns - time_ns) + delay.value() <= 0.0)
        {
            let arrival = Place {
                time_ns: next.start_ns,
                is_arrival: true,
            };
            let has_rested = rests(segment);
            if (is_on || R::MOVES_ALONE) && !has_rested {
                step(runner, run, segment, before, (place, arrival), delay);
            }
            (place, segment) = (arrival, Some(next));
            if next.jumps || has_rested {
                runner.jump(next.q[0]);
            }
        }
        let standing = match segment {
            None => Some(before),
            Some(s) => s.is_constant.then_some(s.q[0]),
        };
        if i > 0 && (is_on || R::MOVES_ALONE) && !rests(segment) {
            let is_along = run.is_even && !place.is_arrival;
            let step_s = seconds(time_ns - place.time_ns);
            if !(is_along && standing.is_some_and(|c| runner.glide(step_s, c))) {
                step(runner, run, segment, before, (place, sample), delay);
            }
        }
        if i > 0 {
            place = sample;
        }
        let level = standing.unwrap_or_else(|| {
            let since = |s: &Segment| s.after(seconds(time_ns - s.start_ns) - delay.value());
            segment.map_or(before, since)
        });
        if motor_on.is_some_and(|on| !on[i].is_nan() && (on[i] != 0.0) != is_on) {
            is_on = !is_on;
            runner.switch(is_on, measured(run, i), level);
        }
        if !(is_on || R::MOVES_ALONE) {
            seen.see(i, S::constant(f64::NAN), f64::NAN, State::Off);
            continue;
        }
        match runner.seen(level) {
            (angle, ..) if rests(segment) => seen.see(i, angle, 0.0, State::Free),
            (angle, rate, state) => seen.see(i, angle, rate, state),
        }
    }
}

/// The last angle that was measured until sample `i`, deg; NaN where there is none, and at the first
/// sample.
#[cold]
fn measured(run: &Experiment, i: usize) -> f64 {
    if i == 0 {
        return f64::NAN;
    }
    let angles = run.recording.angle_deg[..=i].iter().rev();
    angles.copied().find(|a| !a.is_nan()).unwrap_or(f64::NAN)
}

#[inline(always)]
fn seconds(time_ns: i64) -> f64 {
    time_ns as f64 * 1e-9
}

/// Of so few segments, the steps to and from their arrivals are not worth being kept.
const FEW_SEGMENTS: usize = 16;

/// One step between two places under a segment of the command.
fn step<S: Scalar>(
    runner: &mut impl Steps<S>,
    run: &Experiment,
    segment: Option<&Segment>,
    before: f64,
    (from, to): (Place, Place),
    delay: S,
) {
    let length = S::constant(seconds(to.time_ns - from.time_ns));
    let (length, side) = match (from.is_arrival, to.is_arrival) {
        (true, false) => (length - delay, -1),
        (false, true) => (length + delay, 1),
        _ => (length, 0),
    };
    let command = match segment {
        None => Command::Constant(before),
        Some(s) if s.is_constant => Command::Constant(s.q[0]),
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
    let is_worth = side == 0 || run.command.len() > FEW_SEGMENTS;
    let kept = if run.is_even && is_worth {
        Kept::As(side)
    } else {
        Kept::No
    };
    runner.advance(length, kept, &command);
}
