//! What the table of an STS servo commands.
//!
//! Rules that the memory table states are its; what it leaves open is an assumption: the wheel mode's
//! gains are those of [`WHEEL_P`] and [`WHEEL_I`]; an overload ends when the torque is written or a
//! new goal leads the load back; a write of a goal turns the torque on.

use canopen::cia402::{Limits, Ramp};
use servo_bus::feetech::{Event, Server};
use servo_bus::{Answer, Field, tables::sts};

use super::Model;
use super::motor::{Drive, MIDDLE, Motor, PERIOD_S, TURN};

const PERIOD_US: u32 = 1000;

/// Bits of the status.
const VOLTAGE: i32 = 1;
const TEMPERATURE: i32 = 4;
const CURRENT: i32 = 8;
const OVERLOAD: i32 = 32;

/// Duty of the wheel mode per step/s, and per step, and unit of the coefficient: both make the loop of
/// an STS3215 with the defaults of 10 and 10 settle in 0.2 s.
const WHEEL_P: f64 = 1e-5;
const WHEEL_I: f64 = 1e-3;

/// Speed of one in the limits of speeds, steps/s.
const SPEED_UNIT: i32 = 50;

/// Acceleration of one, steps/s^2.
const ACCELERATION_UNIT: u32 = 100;

/// A condition, and the periods for which it has held.
#[derive(Debug, Default)]
struct Timer(i32);

impl Timer {
    /// Whether it has held longer than this time, ms.
    fn exceeds(&mut self, holds: bool, ms: i32) -> bool {
        self.0 = if holds { self.0.saturating_add(1) } else { 0 };
        self.0 > ms
    }
}

/// A servo of the STS series.
#[derive(Debug)]
pub struct Sts {
    pub server: Server,
    pub motor: Motor,
    loop_scale: f64,
    current_unit_a: f64,
    /// The way to the goal.
    ramp: Ramp,
    /// The goal that is in effect, steps of the table.
    goal: i32,
    torque: i32,
    mode: i32,
    error: i32,
    wheel_duty: f64,
    overload: Timer,
    overcurrent: Timer,
    /// Latched bits of the status.
    latched: i32,
    /// Added to the steps of the encoder: whole turns that were reset.
    turns: i32,
}

impl Sts {
    pub fn new(model: &Model, id: u8, motor: Motor) -> Self {
        let mut servo = Self {
            server: Server::new(model.table, id),
            motor,
            loop_scale: model.loop_scale,
            current_unit_a: model.current_unit_a,
            ramp: Ramp::at(0),
            goal: 0,
            torque: 0,
            mode: 0,
            error: 0,
            wheel_duty: 0.0,
            overload: Timer::default(),
            overcurrent: Timer::default(),
            latched: 0,
            turns: 0,
        };
        servo.start();
        servo.publish();
        servo
    }

    fn get(&self, field: Field) -> i32 {
        self.server.memory.get(field)
    }

    fn set(&mut self, field: Field, value: i32) {
        self.server.memory.set(field, value);
    }

    /// A start.
    fn start(&mut self) {
        self.latched = 0;
        self.set(sts::TORQUE_LIMIT, self.get(sts::MAX_TORQUE_LIMIT));
        (self.torque, self.mode) = (0, self.get(sts::OPERATING_MODE));
        self.hold();
        self.set(sts::GOAL_POSITION, self.goal);
    }

    /// The present position as the goal.
    fn hold(&mut self) {
        self.goal = self.position();
        self.ramp = Ramp::at(self.goal);
        (self.error, self.wheel_duty) = (0, 0.0);
    }

    /// The position of the table.
    fn position(&self) -> i32 {
        let raw = self.motor.sensed().position.wrapping_sub(self.turns);
        let position = raw.wrapping_sub(self.get(sts::HOMING_OFFSET));
        if self.has_turns() {
            position
        } else {
            position.rem_euclid(TURN)
        }
    }

    /// Whether positions count turns.
    fn has_turns(&self) -> bool {
        self.mode == 3
            || self.get(sts::MIN_POSITION_LIMIT) == 0 && self.get(sts::MAX_POSITION_LIMIT) == 0
    }

    /// Carries out a packet: what it writes is in effect before the next one.
    pub fn receive(&mut self, packet: &[u8]) -> Option<Answer> {
        let answer = self.server.receive(packet);
        match self.server.take_event() {
            Some(Event::Restart) => self.start(),
            Some(Event::ResetTurns) => self.reset_turns(),
            Some(Event::Calibrate(position)) => self.calibrate(position),
            None => self.take_commands(),
        }
        answer
    }

    /// A period of 1 ms with this supply.
    pub fn step(&mut self, supply_v: f64) {
        let drive = self.drive();
        self.motor.advance(drive, supply_v);
        self.protect();
        self.publish();
    }

    fn reset_turns(&mut self) {
        let raw = self.motor.sensed().position;
        self.turns = raw - raw.rem_euclid(TURN);
        self.hold();
    }

    /// Makes the present position this one, as far as the offset's range reaches: from the seam it
    /// lacks one step.
    fn calibrate(&mut self, position: i32) {
        let raw = self.motor.sensed().position.rem_euclid(TURN);
        let offset = (raw - position + MIDDLE).rem_euclid(TURN) - MIDDLE;
        self.server
            .memory
            .store(sts::HOMING_OFFSET, offset.max(1 - MIDDLE));
        self.hold();
    }

    fn take_commands(&mut self) {
        if self.server.memory.take_written(sts::TORQUE_ENABLE) {
            self.torque_written();
        }
        if self.get(sts::OPERATING_MODE) != self.mode {
            self.mode = self.get(sts::OPERATING_MODE);
            self.hold();
        }
        if self.server.memory.take_written(sts::GOAL_POSITION) && matches!(self.mode, 0 | 3) {
            let goal = self.get(sts::GOAL_POSITION);
            self.goal = if self.mode == 3 {
                self.goal.saturating_add(goal)
            } else {
                self.limited(goal)
            };
            self.latched &= !OVERLOAD;
            self.overload = Timer::default();
            self.enable();
        }
    }

    fn torque_written(&mut self) {
        self.latched = 0;
        self.overload = Timer::default();
        match self.get(sts::TORQUE_ENABLE) {
            128 => {
                self.calibrate(MIDDLE);
                self.set(sts::TORQUE_ENABLE, self.torque);
            }
            1 => self.enable(),
            other => self.torque = other,
        }
    }

    fn enable(&mut self) {
        if self.torque != 1 {
            let goal = self.goal;
            self.hold();
            self.goal = goal;
        }
        self.torque = 1;
        self.set(sts::TORQUE_ENABLE, 1);
    }

    fn limited(&self, goal: i32) -> i32 {
        let (min, max) = (
            self.get(sts::MIN_POSITION_LIMIT),
            self.get(sts::MAX_POSITION_LIMIT),
        );
        if self.has_turns() || min > max {
            goal
        } else {
            goal.clamp(min, max)
        }
    }

    /// Limits of the way to a goal.
    fn limits(&self) -> Limits {
        let most = SPEED_UNIT * self.get(sts::MAXIMUM_VELOCITY_LIMIT);
        let wanted = self.get(sts::GOAL_VELOCITY).abs();
        let velocity = if wanted == 0 { most } else { wanted.min(most) };
        let acceleration = match self.get(sts::ACCELERATION) {
            0 => u32::MAX,
            wanted => {
                ACCELERATION_UNIT * wanted.min(self.get(sts::MAXIMUM_ACCELERATION).max(1)) as u32
            }
        };
        Limits {
            velocity: velocity as u32,
            acceleration,
            deceleration: acceleration,
        }
    }

    fn drive(&mut self) -> Drive {
        match self.torque {
            0 => return Drive::Free,
            1 => {}
            _ => return Drive::Brake,
        }
        let duty = match self.mode {
            1 => self.wheel(),
            2 => f64::from(self.get(sts::GOAL_TIME)) / 1000.0,
            _ => self.position_duty(),
        };
        let mut most = f64::from(self.get(sts::TORQUE_LIMIT)) / 1000.0;
        if self.latched & OVERLOAD != 0 {
            most = most.min(f64::from(self.get(sts::PROTECTIVE_TORQUE)) / 100.0);
        }
        Drive::Duty(duty.clamp(-most, most))
    }

    /// Duty of the position loop: P/4 and D/8 in 0.1 % per step and per step/ms, nothing within the
    /// dead zone, and at least the starting force outside of it.
    fn position_duty(&mut self) -> f64 {
        let limits = self.limits();
        self.ramp.to_position(self.goal, &limits, PERIOD_US);
        let error = self.ramp.position() - self.position();
        let change = error - std::mem::replace(&mut self.error, error);
        let dead_zone = if error > 0 {
            sts::CW_DEAD_ZONE
        } else {
            sts::CCW_DEAD_ZONE
        };
        if error.abs() <= self.get(dead_zone) {
            return 0.0;
        }
        let p = f64::from(self.get(sts::P_COEFFICIENT)) / 4.0 * f64::from(error);
        let d = f64::from(self.get(sts::D_COEFFICIENT)) / 8.0 * f64::from(change);
        let duty = self.loop_scale * (p + d) / 1000.0;
        let least = f64::from(self.get(sts::MINIMUM_STARTUP_FORCE)) / 1000.0;
        if duty == 0.0 {
            0.0
        } else {
            duty.signum() * duty.abs().max(least)
        }
    }

    /// Duty of the wheel mode: PI on the rate.
    fn wheel(&mut self) -> f64 {
        let most = SPEED_UNIT * self.get(sts::MAXIMUM_VELOCITY_LIMIT);
        let goal = self.get(sts::GOAL_VELOCITY).clamp(-most, most);
        self.ramp
            .to_velocity(goal, &self.limits_of_wheel(most), PERIOD_US);
        let error = f64::from(self.ramp.velocity()) - self.motor.sensed().rate;
        let gain = f64::from(self.get(sts::VELOCITY_I_COEFFICIENT)) * WHEEL_I;
        self.wheel_duty = (self.wheel_duty + gain * error * PERIOD_S).clamp(-1.0, 1.0);
        f64::from(self.get(sts::VELOCITY_P_COEFFICIENT)) * WHEEL_P * error + self.wheel_duty
    }

    fn limits_of_wheel(&self, most: i32) -> Limits {
        Limits {
            velocity: most as u32,
            ..self.limits()
        }
    }

    fn protect(&mut self) {
        let sensed = *self.motor.sensed();
        let acts = self.get(sts::UNLOADING_CONDITION);
        let overload = f64::from(self.get(sts::OVERLOAD_TORQUE)) / 100.0;
        let is_overloaded = self.latched & OVERLOAD == 0
            && sensed.duty.abs() > overload
            && sensed.rate.abs() < 50.0;
        if self
            .overload
            .exceeds(is_overloaded, 10 * self.get(sts::PROTECTION_TIME))
        {
            self.latched |= OVERLOAD & acts;
        }
        let most_a = f64::from(self.get(sts::PROTECTION_CURRENT)) * self.current_unit_a;
        let is_high = most_a > 0.0 && sensed.current_a.abs() > most_a;
        if self
            .overcurrent
            .exceeds(is_high, 10 * self.get(sts::OVERCURRENT_TIME))
        {
            self.latched |= CURRENT & acts;
        }
        let is_hot = sensed.temperature_c > f64::from(self.get(sts::MAX_TEMPERATURE_LIMIT));
        let volts = sensed.supply_v * 10.0;
        let (low, high) = (
            self.get(sts::MIN_VOLTAGE_LIMIT),
            self.get(sts::MAX_VOLTAGE_LIMIT),
        );
        let is_out = volts < f64::from(low) || volts > f64::from(high);
        let present = if is_hot { TEMPERATURE } else { 0 } | if is_out { VOLTAGE } else { 0 };
        self.set(sts::STATUS, self.latched | present);
        let ends = CURRENT & self.latched | (TEMPERATURE | VOLTAGE) & present & acts;
        if ends != 0 && self.torque != 0 {
            self.torque = 0;
            self.set(sts::TORQUE_ENABLE, 0);
        }
    }

    fn publish(&mut self) {
        let sensed = *self.motor.sensed();
        let position = if self.mode == 3 {
            self.goal.wrapping_sub(self.position())
        } else {
            self.position()
        };
        self.set(sts::PRESENT_POSITION, position.clamp(-32_767, 32_767));
        self.set(
            sts::PRESENT_VELOCITY,
            (sensed.rate.round() as i32).clamp(-32_767, 32_767),
        );
        self.set(sts::PRESENT_LOAD, (sensed.duty * 1000.0).round() as i32);
        self.set(
            sts::PRESENT_VOLTAGE,
            (sensed.supply_v * 10.0).round() as i32,
        );
        self.set(
            sts::PRESENT_TEMPERATURE,
            sensed.temperature_c.round() as i32,
        );
        self.set(
            sts::PRESENT_CURRENT,
            (sensed.current_a / self.current_unit_a).round() as i32,
        );
        self.set(
            sts::GOAL_POSITION_IN_EFFECT,
            self.goal.clamp(-32_767, 32_767),
        );
        let is_under_way =
            self.torque == 1 && matches!(self.mode, 0 | 3) && self.ramp.position() != self.goal;
        let threshold = SPEED_UNIT * self.get(sts::MOVING_THRESHOLD);
        let is_moving = is_under_way || sensed.rate.abs() > f64::from(threshold);
        self.set(sts::MOVING, i32::from(is_moving));
    }
}
