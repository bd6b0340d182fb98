//! The output shaft, integrated in short steps.
//!
//! Each step is the implicit midpoint rule for the smooth terms, and the stopping torque for
//! friction: a shaft at rest whose torque is within the friction budget keeps a rate of exactly
//! zero. A step in which the shaft comes to rest is divided at that instant, because friction then
//! has another direction. The error of a step is of third order.

use crate::hybrid::{Caching, Command, Stepper};
use crate::model::ActiveLimit;
use crate::scalar::Scalar;

use super::super::friction::Friction;
use super::{DEGREE, MotorValues};

/// The longest step, s: a fiftieth of the time constants of small servos.
const LONGEST_STEP_S: f64 = 5e-4;

/// The same in a search for starting values.
const PREVIEW_STEP_S: f64 = 2e-3;

/// Standard gravity, m/s^2 (ISO 80000-3).
const GRAVITY_M_S2: f64 = 9.80665;

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
    /// The angle on the encoder's side of the backlash.
    encoder: S,
    state: ActiveLimit,
    /// Whether the motor is on; when it is off, its terminals are open.
    is_on: bool,
    longest_step_s: f64,
}

impl<S: Scalar> Shaft<S> {
    pub fn new(friction: usize, p: &MotorValues<S>, supply_v: S, is_loop: bool) -> Self {
        let ratio = p.gear_ratio;
        let constant = p.torque_constant_nm_a * ratio;
        let torque_per_volt = constant / p.winding_resistance_ohm;
        let (mass, length) = (p.pendulum_mass_kg, p.pendulum_length_m);
        let angle = p.initial_angle_deg * DEGREE;
        Self {
            friction: Friction::new(friction, p),
            is_loop,
            supply_v,
            torque_per_volt,
            back_emf: torque_per_volt * constant,
            inertia: p.motor_inertia_kg_m2 * ratio * ratio + mass * length * length,
            weight_nm: mass * length * GRAVITY_M_S2,
            vertical: p.vertical_deg * DEGREE,
            load_nm: p.load_torque_nm,
            duty_per_rad: p.duty_per_error_pct_deg * p.firmware_gain * (0.01 / DEGREE),
            duty_limit: p.duty_limit_pct * 0.01,
            asymmetry: p.drive_asymmetry,
            stop: p.hard_stop_deg * DEGREE,
            half_gap: p.backlash_deg * (DEGREE / 2.0),
            angle,
            rate: p.initial_rate_deg_s * DEGREE,
            encoder: angle,
            state: ActiveLimit::Free,
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

    /// The voltage for an input: a duty, or a commanded angle, deg.
    fn voltage(&mut self, input: S, angle: S) -> S {
        let mut duty = input;
        if self.is_loop {
            duty = (input * DEGREE - angle) * self.duty_per_rad;
        }
        let limited = duty.within(-self.duty_limit, self.duty_limit);
        // A logged duty is what its own limit has left of it.
        self.state = if !self.is_loop || limited.value() == duty.value() {
            ActiveLimit::Free
        } else {
            ActiveLimit::Duty
        };
        let sign = if limited.value() < 0.0 { -1.0 } else { 1.0 };
        limited * self.supply_v * (self.asymmetry * sign + 1.0)
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
            self.state = ActiveLimit::Free;
            (off, off)
        };
        let external_nm = self.external_nm(middle);
        let motor_nm = drive_nm - back_emf * self.rate;
        let budget = self.friction.budget_nm(self.rate, motor_nm, external_nm);
        // J (w1 - w)/h = drive + external - (k^2/R + b) (w + w1)/2 + friction
        let half = (back_emf + self.friction.viscous_nm_s) * 0.5;
        let torque = drive_nm + external_nm;
        if let Some(until_rest) = self.until_rest(budget, torque - half * self.rate, step) {
            self.turn(until_rest, S::constant(0.0));
            return self.step(step - until_rest, input);
        }
        let momentum = self.inertia / step;
        let stopping = (momentum - half) * self.rate + torque;
        let held = stopping.within(-budget, budget);
        let rate = (stopping - held) / (momentum + half);
        if rate.value() == 0.0 && self.state == ActiveLimit::Free {
            self.state = ActiveLimit::Stuck;
        }
        self.turn(step, rate);
    }

    /// After which time a moving shaft with this torque comes to rest, if within the step. Without
    /// this instant, which moves with each parameter, the angle would jump by more than the
    /// resolution of an encoder.
    fn until_rest(&self, budget: S, torque: S, step: S) -> Option<S> {
        let sign = match self.rate.value() {
            0.0 => return None,
            rate => rate.signum(),
        };
        let until_rest = self.inertia * self.rate / (budget * sign - torque);
        let is_within = until_rest.value() > 0.0 && until_rest.value() < step.value();
        is_within.then_some(until_rest)
    }

    /// Turns the shaft for a time in which its rate changes to this one.
    fn turn(&mut self, step: S, rate: S) {
        self.angle = self.angle + (self.rate + rate) * step * 0.5;
        self.rate = rate;
        if self.angle.value().abs() > self.stop.value() {
            let sign = self.angle.value().signum();
            self.angle = self.stop * sign;
            self.rate = S::constant(0.0);
            self.state = ActiveLimit::Stop;
        }
        self.encoder = self
            .encoder
            .within(self.angle - self.half_gap, self.angle + self.half_gap);
    }
}

impl<S: Scalar> Stepper<S> for Shaft<S> {
    const MODELS_MOTOR_OFF: bool = true;

    fn switch_motor(&mut self, is_on: bool, _angle_deg: f64, _command: f64) {
        self.is_on = is_on;
    }

    fn advance(&mut self, step: S, _key: Caching, command: &Command<S>) {
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

    fn command_jumped(&mut self, _command: f64) {}

    fn output(&self, _command: f64) -> (S, f64, ActiveLimit) {
        let angle = self.encoder * (1.0 / DEGREE);
        (angle, self.rate.value() / DEGREE, self.state)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::ParameterValues;

    /// The rate after a time `t_s` in which it approaches `end`, and the angle turned.
    fn approach(rate: f64, end: f64, t_s: f64, constant_s: f64) -> (f64, f64) {
        let gone = 1.0 - (-t_s / constant_s).exp();
        let turned = end * t_s + (rate - end) * constant_s * gone;
        (rate + (end - rate) * gone, turned)
    }

    #[test]
    fn a_motor_that_reverses_within_a_step_follows_the_closed_form() {
        for supply_v in (0..20).map(|i| 10.0 + 0.1 * f64::from(i)) {
            let p = MotorValues {
                torque_constant_nm_a: 0.3,
                winding_resistance_ohm: 5.0,
                motor_inertia_kg_m2: 0.01,
                coulomb_friction_nm: 0.05,
                ..MotorValues::<f64>::defaults()
            };
            let mut shaft = Shaft::new(1, &p, supply_v, false);
            let damping = shaft.back_emf + shaft.friction.viscous_nm_s;
            let (constant_s, friction) = (shaft.inertia / damping, 0.05 / damping);
            let driven = shaft.torque_per_volt * supply_v / damping;
            let (forward, backward) = (400, 2000);
            for (steps, duty) in [(forward, 1.0), (backward, -1.0)] {
                (0..steps).for_each(|_| shaft.step(LONGEST_STEP_S, duty));
            }
            let [forward_s, backward_s] =
                [forward, backward].map(|n| f64::from(n) * LONGEST_STEP_S);
            let (rate, out) = approach(0.0, driven - friction, forward_s, constant_s);
            let braked = -driven - friction;
            let rest_s = constant_s * (1.0 - rate / braked).ln();
            let (rest, on) = approach(rate, braked, rest_s, constant_s);
            let (_, back) = approach(rest, friction - driven, backward_s - rest_s, constant_s);
            let error_deg = (shaft.angle - out - on - back) / DEGREE;
            // That of the midpoint rule. One direction of friction in a whole step would be off by
            // as much as the resolution of an encoder.
            assert!(error_deg.abs() < 1e-3, "{supply_v} V: {error_deg} deg");
        }
    }
}
