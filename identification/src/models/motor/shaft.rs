//! The output shaft, moved in short steps.
//!
//! Each step is the implicit midpoint rule for all that is smooth, and the stopping torque for
//! friction: what stands still under less than its budget keeps a rate of exactly zero. The error of
//! a step is of third order while the sense of the motion stays.

use crate::flow::{Command, Kept, Steps};
use crate::model::State;
use crate::scalar::Scalar;

use super::super::friction::Friction;
use super::{
    ANGLE, ASYMMETRY, BACKLASH, COUNT, DUTY_LIMIT, DUTY_PER_ERROR, FIRMWARE, FRICTION, GEAR_RATIO,
    INERTIA, LENGTH, LOAD, MASS, RATE, RESISTANCE, STOP, TORQUE_CONSTANT, VERTICAL,
};

/// The longest step, s: a fiftieth of the time constants of small servos.
const LONGEST_STEP_S: f64 = 5e-4;

/// The same where only a start is looked for.
const PREVIEW_STEP_S: f64 = 2e-3;

/// Standard gravity, m/s^2 (ISO 80000-3).
const GRAVITY_M_S2: f64 = 9.80665;

const DEGREE: f64 = std::f64::consts::PI / 180.0;

pub struct Shaft<S> {
    friction: Friction<S>,
    is_loop: bool,
    supply_v: S,
    /// `k/R`, Nm/V.
    torque_per_volt: S,
    /// `k^2/R`, Nm s/rad.
    back_emf: S,
    inertia: S,
    weight_nm: S,
    vertical: S,
    load_nm: S,
    duty_per_rad: S,
    duty_limit: S,
    asymmetry: S,
    stop: S,
    half_gap: S,
    angle: S,
    rate: S,
    /// The encoder's side of the backlash.
    shown: S,
    state: State,
    /// Whether the motor is on; off, its terminals are open.
    is_on: bool,
    longest_step_s: f64,
}

impl<S: Scalar> Shaft<S> {
    pub fn new(friction: usize, values: &[S], supply_v: S, is_loop: bool) -> Self {
        let ratio = values[GEAR_RATIO];
        let constant = values[TORQUE_CONSTANT] * ratio;
        let torque_per_volt = constant / values[RESISTANCE];
        let (mass, length) = (values[MASS], values[LENGTH]);
        let angle = values[ANGLE] * DEGREE;
        Self {
            friction: Friction::new(friction, &values[FRICTION..FRICTION + COUNT]),
            is_loop,
            supply_v,
            torque_per_volt,
            back_emf: torque_per_volt * constant,
            inertia: values[INERTIA] * ratio * ratio + mass * length * length,
            weight_nm: mass * length * GRAVITY_M_S2,
            vertical: values[VERTICAL] * DEGREE,
            load_nm: values[LOAD],
            duty_per_rad: values[DUTY_PER_ERROR] * values[FIRMWARE] * (0.01 / DEGREE),
            duty_limit: values[DUTY_LIMIT] * 0.01,
            asymmetry: values[ASYMMETRY],
            stop: values[STOP] * DEGREE,
            half_gap: values[BACKLASH] * (DEGREE / 2.0),
            angle,
            rate: values[RATE] * DEGREE,
            shown: angle,
            state: State::Free,
            is_on: true,
            longest_step_s: LONGEST_STEP_S,
        }
    }

    /// The same in longer steps.
    pub fn in_longer_steps(self) -> Self {
        Self {
            longest_step_s: PREVIEW_STEP_S,
            ..self
        }
    }

    /// The voltage for an input: a duty, or a commanded angle in deg.
    fn voltage(&mut self, input: S, angle: S) -> S {
        let mut duty = input;
        if self.is_loop {
            duty = (input * DEGREE - angle) * self.duty_per_rad;
        }
        let limited = duty.within(-self.duty_limit, self.duty_limit);
        self.state = if limited.value() == duty.value() {
            State::Free
        } else {
            State::Duty
        };
        let sense = if limited.value() < 0.0 { -1.0 } else { 1.0 };
        limited * self.supply_v * (self.asymmetry * sense + 1.0)
    }

    fn external_nm(&self, angle: S) -> S {
        self.load_nm - self.weight_nm * (angle - self.vertical).sin()
    }

    fn step(&mut self, step: S, input: S) {
        let middle = self.angle + self.rate * step * 0.5;
        let off = S::constant(0.0);
        let (drive_nm, back_emf) = if self.is_on {
            let voltage = self.voltage(input, middle);
            (self.torque_per_volt * voltage, self.back_emf)
        } else {
            self.state = State::Free;
            (off, off)
        };
        let external_nm = self.external_nm(middle);
        let motor_nm = drive_nm - back_emf * self.rate;
        let budget = self.friction.budget_nm(self.rate, motor_nm, external_nm);
        // J (w1 - w)/h = drive + external - k^2/R (w + w1)/2 + friction
        let momentum = self.inertia / step;
        let half = back_emf * 0.5;
        let stopping = (momentum - half) * self.rate + drive_nm + external_nm;
        let held = stopping.within(-budget, budget);
        let rate = (stopping - held) / (momentum + half);
        if rate.value() == 0.0 && self.state == State::Free {
            self.state = State::Stuck;
        }
        self.angle = self.angle + (self.rate + rate) * step * 0.5;
        self.rate = rate;
        if self.angle.value().abs() > self.stop.value() {
            let sense = self.angle.value().signum();
            self.angle = self.stop * sense;
            self.rate = S::constant(0.0);
            self.state = State::Stop;
        }
        self.shown = self
            .shown
            .within(self.angle - self.half_gap, self.angle + self.half_gap);
    }
}

impl<S: Scalar> Steps<S> for Shaft<S> {
    const MOVES_ALONE: bool = true;

    fn switch(&mut self, is_on: bool, _angle_deg: f64, _command: f64) {
        self.is_on = is_on;
    }

    fn advance(&mut self, step: S, _kept: Kept, command: &Command<S>) {
        // `as` takes NaN to 0 and saturates.
        let parts = (step.value() / self.longest_step_s).ceil().clamp(1.0, 1e6) as usize;
        if step.value() <= 0.0 {
            return;
        }
        let part = step * (1.0 / parts as f64);
        for i in 0..parts {
            let input = match command {
                Command::Constant(value) => S::constant(*value),
                Command::Cubic(_) => match command.later(part * (i as f64 + 0.5)) {
                    Command::Cubic([level, ..]) => level,
                    Command::Constant(value) => S::constant(value),
                },
            };
            self.step(part, input);
        }
    }

    fn jump(&mut self, _command: f64) {}

    fn seen(&self, _command: f64) -> (S, f64, State) {
        let angle = self.shown * (1.0 / DEGREE);
        (angle, self.rate.value() / DEGREE, self.state)
    }
}
