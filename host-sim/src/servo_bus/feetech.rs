//! What the table of an STS servo commands.
//!
//! Rules that the memory table states are its; what it leaves open is an assumption: the wheel
//! mode's gains are those of [`WHEEL_P`] and [`WHEEL_I`]; an overload ends when the torque is
//! written or a new goal leads the load back; a write of a goal turns the torque on.

mod control;
mod report;

use canopen::cia402::Ramp;
use servo_bus::feetech::{Event, Server};
use servo_bus::{Answer, Field, tables::sts};

use super::Model;
use super::motor::{MIDDLE, Motor, TURN};

/// Bit of the status.
const OVERLOAD: i32 = 32;

/// Speed of one in the limits of speeds, steps/s.
const SPEED_UNIT: i32 = 50;

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
}
