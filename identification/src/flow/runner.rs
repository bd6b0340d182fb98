//! A model in motion, from mode to mode.

use super::ladder::Ladder;
use super::propagator::{Kept, Propagator};
use super::{Command, Face, Flow, crossing, values};
use crate::scalar::Scalar;

/// By how much a face may be below zero without being crossed: rounding of values of 1e3.
pub const SLACK: f64 = 1e-9;

/// Crossings within one step after which the mode is decided anew.
const MOST_CROSSINGS: usize = 16;

/// All that is known of a mode.
pub struct Mode<S, const N: usize> {
    pub linear: Propagator<S, N>,
    /// The same without derivatives: looks along a long step whether it leaves the mode.
    scout: Propagator<f64, N>,
    pub faces: Vec<Face<S, N>>,
    /// The same without derivatives.
    pub edges: Vec<Face<f64, N>>,
}

impl<S: Scalar, const N: usize> Mode<S, N> {
    /// Whether a state lies beyond a face. NaN does not: no crossing is looked for there.
    #[inline(always)]
    fn is_left(&self, x: &[S; N], command: f64) -> bool {
        is_beyond(&self.edges, &values(x), command)
    }
}

#[inline(always)]
fn is_beyond<const N: usize>(edges: &[Face<f64, N>], x: &[f64; N], command: f64) -> bool {
    edges.iter().any(|edge| edge.at(x, command) < -SLACK)
}

/// A model in motion.
pub struct Runner<'a, F, S, const N: usize> {
    pub flow: &'a F,
    modes: Vec<Option<Box<Mode<S, N>>>>,
    pub mode: usize,
    pub x: [S; N],
    /// Whether it was off from the start, and so has not left its first state.
    has_rested: bool,
}

/// A mode that was left: when, and the one that was entered.
type Crossing<S> = (S, usize);

impl<'a, S: Scalar, const N: usize, F: Flow<S, N>> Runner<'a, F, S, N> {
    pub fn new(flow: &'a F, x: [S; N], command: f64) -> Self {
        let mut runner = Self {
            flow,
            modes: (0..F::MODES).map(|_| None).collect(),
            mode: 0,
            x,
            has_rested: false,
        };
        runner.decide(command);
        runner
    }

    /// Finds the mode from state and command alone, as after a jump of the command.
    pub fn decide(&mut self, command: f64) {
        self.change(self.flow.mode_at(&values(&self.x), command));
    }

    /// The motor is switched. Once it was on, it begins anew at rest where the angle is measured.
    #[cold]
    pub fn switch(&mut self, is_on: bool, angle_deg: f64, command: f64) {
        if !is_on {
            self.has_rested |= angle_deg.is_nan();
            return;
        }
        if !self.has_rested && !angle_deg.is_nan() {
            self.x = [S::constant(0.0); N];
            self.x[0] = S::constant(angle_deg);
        }
        self.has_rested = false;
        self.decide(command);
    }

    fn change(&mut self, mode: usize) {
        self.mode = mode;
        self.flow.enter(mode, &mut self.x);
        let flow = self.flow;
        self.modes[mode].get_or_insert_with(|| {
            let faces = flow.faces(mode);
            let system = flow.system(mode);
            Box::new(Mode {
                scout: Propagator::new(system.without_derivatives()),
                linear: Propagator::new(system),
                edges: faces.iter().map(Face::without_derivatives).collect(),
                faces,
            })
        });
    }

    /// Moves through a step like the last one if it ends in the same mode: most do.
    #[inline(always)]
    pub fn glide(&mut self, step_s: f64, command: f64) -> bool {
        let Some(mode) = self.modes[self.mode].as_deref_mut() else {
            return false;
        };
        let Some(end) = mode.linear.again(&self.x, command, step_s) else {
            return false;
        };
        let stays = !mode.is_left(&end, command);
        if stays {
            self.x = end;
        }
        stays
    }

    /// Moves through `step`; `kept` is how to keep what is computed for its length.
    pub fn advance(&mut self, step: S, kept: Kept, command: &Command<S>) {
        let (mut left, mut kept, mut command) = (step, kept, *command);
        for _ in 0..MOST_CROSSINGS {
            let Some((at, next)) = self.advance_inside(left, kept, &mut command) else {
                return;
            };
            left = left - at;
            kept = Kept::No;
            self.change(next);
        }
        // A mode that is left as soon as it is entered: what state and command say decides.
        self.decide(command.value_after(0.0));
        self.advance_inside(left, Kept::No, &mut command);
    }

    /// Moves until the end of `step` or the first crossing, whichever comes first, and takes the
    /// command along.
    fn advance_inside(
        &mut self,
        step: S,
        kept: Kept,
        command: &mut Command<S>,
    ) -> Option<Crossing<S>> {
        let mode = self.modes[self.mode].as_deref_mut()?;
        if mode.linear.is_too_fast() {
            self.x = [S::constant(f64::NAN); N];
            return None;
        }
        let (rest, rungs) = mode.linear.cut(step);
        if let (1.., Kept::As(side)) = (rungs, kept)
            && mode.stays(&self.x, command, step.value(), kept)
        {
            self.x = mode.linear.leap(&self.x, command, step, side);
            return None;
        }
        let end = mode.linear.propagate(&self.x, command, rest, kept);
        if mode.is_left(&end, command.value_after(rest.value())) {
            return Some(mode.cross(&mut self.x, command, rest));
        }
        self.x = end;
        if rungs == 0 {
            return None;
        }
        *command = command.later(rest);
        let mut done = 0;
        while done < rungs {
            let rung = Ladder::<S, N>::next(done, rungs - done);
            if let Some((at, next)) = mode.climb(&mut self.x, command, rung) {
                let before = mode.linear.ladder.rung_s(0) * done as f64;
                return Some((rest + before + at, next));
            }
            done += 1 << rung;
        }
        None
    }
}

impl<S: Scalar, const N: usize> Mode<S, N> {
    /// Moves to the first crossing within a short step that ends outside.
    #[cold]
    fn cross(&self, x: &mut [S; N], command: &mut Command<S>, step: S) -> Crossing<S> {
        let crossing = crossing::first(self, x, command, step);
        *x = crossing.x;
        *command = command.later(crossing.time);
        (crossing.time, crossing.next)
    }

    /// Whether a long step ends in the mode and passes no limit on the way.
    fn stays(&mut self, x: &[S; N], command: &Command<S>, step_s: f64, kept: Kept) -> bool {
        let (rest_s, rungs) = self.scout.cut(step_s);
        let mut command = command.without_derivatives();
        let mut x = self.scout.propagate(&values(x), &command, rest_s, kept);
        command = command.later(rest_s);
        let mut done = 0;
        while done < rungs && !is_beyond(&self.edges, &x, command.value_after(0.0)) {
            let rung = Ladder::<f64, N>::next(done, rungs - done);
            x = self.scout.climb(&x, &command, rung);
            command = command.later(self.scout.ladder.rung_s(rung));
            done += 1 << rung;
        }
        !is_beyond(&self.edges, &x, command.value_after(0.0))
    }

    /// Moves over a rung, or to the first crossing within it.
    fn climb(
        &mut self,
        x: &mut [S; N],
        command: &mut Command<S>,
        rung: usize,
    ) -> Option<Crossing<S>> {
        let length = S::constant(self.linear.ladder.rung_s(rung));
        let end = self.linear.climb(x, command, rung);
        if !self.is_left(&end, command.value_after(length.value())) {
            *x = end;
            *command = command.later(length);
            return None;
        }
        let Some(half) = rung.checked_sub(1) else {
            return Some(self.cross(x, command, length));
        };
        if let Some(crossing) = self.climb(x, command, half) {
            return Some(crossing);
        }
        let (at, next) = self.climb(x, command, half)?;
        Some((at + self.linear.ladder.rung_s(half), next))
    }
}
