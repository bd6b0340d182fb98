//! Simulates a hybrid system from mode to mode.

use super::doubling::StepDoubling;
use super::propagator::{Caching, Propagator};
use super::{Command, Guard, HybridModel, crossing, values};
use crate::scalar::Scalar;

/// Tolerance of a guard below zero: rounding of values of 1e3.
pub const TOLERANCE: f64 = 1e-9;

/// Events within one step after which the mode is selected from state and command.
const MOST_CROSSINGS: usize = 16;

/// A mode with its cached results.
pub struct Mode<S, const N: usize> {
    pub linear: Propagator<S, N>,
    /// The same without derivatives: checks whether a long step leaves the mode.
    plain: Propagator<f64, N>,
    pub guards: Vec<Guard<S, N>>,
    /// The same without derivatives.
    pub plain_guards: Vec<Guard<f64, N>>,
}

impl<S: Scalar, const N: usize> Mode<S, N> {
    /// Whether a state violates a guard. NaN does not, so that no event is located for it.
    #[inline(always)]
    fn violates_guard(&self, x: &[S; N], command: f64) -> bool {
        violates(&self.plain_guards, &values(x), command)
    }
}

#[inline(always)]
fn violates<const N: usize>(plain_guards: &[Guard<f64, N>], x: &[f64; N], command: f64) -> bool {
    plain_guards
        .iter()
        .any(|guard| guard.at(x, command) < -TOLERANCE)
}

/// A hybrid system, its mode and its state.
pub struct HybridSimulator<'a, F, S, const N: usize> {
    pub model: &'a F,
    modes: Vec<Option<Box<Mode<S, N>>>>,
    pub mode: usize,
    pub x: [S; N],
    /// Whether the motor was off from the start, so that the initial state still holds.
    was_off_from_start: bool,
}

/// An event: its time, and the mode that is entered.
type Event<S> = (S, usize);

impl<'a, S: Scalar, const N: usize, F: HybridModel<S, N>> HybridSimulator<'a, F, S, N> {
    pub fn new(model: &'a F, x: [S; N], command: f64) -> Self {
        let mut simulator = Self {
            model,
            modes: (0..F::MODES).map(|_| None).collect(),
            mode: 0,
            x,
            was_off_from_start: false,
        };
        simulator.select_mode(command);
        simulator
    }

    /// Selects the mode from state and command, as after a jump of the command.
    pub fn select_mode(&mut self, command: f64) {
        self.enter_mode(self.model.mode_at(&values(&self.x), command));
    }

    /// Switches the motor. After it was on before, it restarts at rest at the measured angle.
    #[cold]
    pub fn switch_motor(&mut self, is_on: bool, angle_deg: f64, command: f64) {
        if !is_on {
            self.was_off_from_start |= angle_deg.is_nan();
            return;
        }
        if !self.was_off_from_start && !angle_deg.is_nan() {
            self.x = [S::constant(0.0); N];
            self.x[0] = S::constant(angle_deg);
        }
        self.was_off_from_start = false;
        self.select_mode(command);
    }

    fn enter_mode(&mut self, mode: usize) {
        self.mode = mode;
        self.model.reset(mode, &mut self.x);
        let model = self.model;
        self.modes[mode].get_or_insert_with(|| {
            let guards = model.guards(mode);
            let system = model.system(mode);
            Box::new(Mode {
                plain: Propagator::new(system.without_derivatives()),
                linear: Propagator::new(system),
                plain_guards: guards.iter().map(Guard::without_derivatives).collect(),
                guards,
            })
        });
    }

    /// Repeats the last step if it ends in the same mode, as most steps do.
    #[inline(always)]
    pub fn repeat_step(&mut self, step_s: f64, command: f64) -> bool {
        let Some(mode) = self.modes[self.mode].as_deref_mut() else {
            return false;
        };
        let Some(end) = mode.linear.repeat(&self.x, command, step_s) else {
            return false;
        };
        let remains_in_mode = !mode.violates_guard(&end, command);
        if remains_in_mode {
            self.x = end;
        }
        remains_in_mode
    }

    /// Advances by `step`; `caching` selects how the results for its length are cached.
    pub fn advance(&mut self, step: S, caching: Caching, command: &Command<S>) {
        let (mut left, mut caching, mut command) = (step, caching, *command);
        for _ in 0..MOST_CROSSINGS {
            let Some((at, next)) = self.advance_inside(left, caching, &mut command) else {
                return;
            };
            left = left - at;
            caching = Caching::Off;
            self.enter_mode(next);
        }
        // A mode that is left as soon as it is entered: state and command select the mode.
        self.select_mode(command.value_after(0.0));
        self.advance_inside(left, Caching::Off, &mut command);
    }

    /// Advances to the end of `step` or the first event, whichever comes first, and shifts the
    /// command accordingly.
    fn advance_inside(
        &mut self,
        step: S,
        caching: Caching,
        command: &mut Command<S>,
    ) -> Option<Event<S>> {
        let mode = self.modes[self.mode].as_deref_mut()?;
        if mode.linear.is_too_fast() {
            self.x = [S::constant(f64::NAN); N];
            return None;
        }
        let (rest, steps) = mode.linear.split(step);
        if let (1.., Caching::Keyed(side)) = (steps, caching)
            && mode.remains_in_mode(&self.x, command, step.value(), caching)
        {
            self.x = mode.linear.long_step(&self.x, command, step, side);
            return None;
        }
        let end = mode.linear.propagate(&self.x, command, rest, caching);
        if mode.violates_guard(&end, command.value_after(rest.value())) {
            return Some(mode.cross(&mut self.x, command, rest));
        }
        self.x = end;
        if steps == 0 {
            return None;
        }
        *command = command.later(rest);
        let mut done = 0;
        while done < steps {
            let level = StepDoubling::<S, N>::next(done, steps - done);
            if let Some((at, next)) = mode.advance_level(&mut self.x, command, level) {
                let before = mode.linear.doubling.level_s(0) * done as f64;
                return Some((rest + before + at, next));
            }
            done += 1 << level;
        }
        None
    }
}

impl<S: Scalar, const N: usize> Mode<S, N> {
    /// Advances to the first event within a short step that ends outside the mode.
    #[cold]
    fn cross(&self, x: &mut [S; N], command: &mut Command<S>, step: S) -> Event<S> {
        let crossing = crossing::first(self, x, command, step);
        *x = crossing.x;
        *command = command.later(crossing.time);
        (crossing.time, crossing.next)
    }

    /// Whether a long step stays within the mode.
    fn remains_in_mode(
        &mut self,
        x: &[S; N],
        command: &Command<S>,
        step_s: f64,
        caching: Caching,
    ) -> bool {
        let (rest_s, steps) = self.plain.split(step_s);
        let mut command = command.without_derivatives();
        let mut x = self.plain.propagate(&values(x), &command, rest_s, caching);
        command = command.later(rest_s);
        let mut done = 0;
        while done < steps && !violates(&self.plain_guards, &x, command.value_after(0.0)) {
            let level = StepDoubling::<f64, N>::next(done, steps - done);
            x = self.plain.advance_level(&x, &command, level);
            command = command.later(self.plain.doubling.level_s(level));
            done += 1 << level;
        }
        !violates(&self.plain_guards, &x, command.value_after(0.0))
    }

    /// Advances by a sub-step of a level, or to the first event within it.
    fn advance_level(
        &mut self,
        x: &mut [S; N],
        command: &mut Command<S>,
        level: usize,
    ) -> Option<Event<S>> {
        let length = S::constant(self.linear.doubling.level_s(level));
        let end = self.linear.advance_level(x, command, level);
        if !self.violates_guard(&end, command.value_after(length.value())) {
            *x = end;
            *command = command.later(length);
            return None;
        }
        let Some(half) = level.checked_sub(1) else {
            return Some(self.cross(x, command, length));
        };
        if let Some(crossing) = self.advance_level(x, command, half) {
            return Some(crossing);
        }
        let (at, next) = self.advance_level(x, command, half)?;
        Some((at + self.linear.doubling.level_s(half), next))
    }
}
