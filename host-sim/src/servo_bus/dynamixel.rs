//! What the table of a Dynamixel of the X series commands.
//!
//! Rules are those of the pages of emanual.robotis.com. What they leave open is an assumption:
//! gains count periods of 1 ms; the current loop is ideal; an overload is an output of 80 % or more
//! without motion for 1 s; feedforward gains have no effect.

mod control;
mod report;

use canopen::cia402::{Limits, Ramp};
use servo_bus::dynamixel::{Event, Server};
use servo_bus::{Answer, Field, tables::x};

use super::Model;
use super::motor::{Drive, Motor, TURN};

/// PWM of the whole supply.
const FULL_PWM: f64 = 885.0;

/// Velocity of one, 0.229 rev/min, in steps/s.
const VELOCITY_UNIT: f64 = 0.229 * TURN as f64 / 60.0;

/// Operating modes.
const CURRENT_MODE: i32 = 0;
const VELOCITY_MODE: i32 = 1;
const POSITION_MODE: i32 = 3;
const CURRENT_POSITION_MODE: i32 = 5;
const PWM_MODE: i32 = 16;

/// A servo of the X series.
#[derive(Debug)]
pub struct X {
    pub server: Server,
    pub motor: Motor,
    loop_scale: f64,
    current_unit_a: f64,
    ramp: Ramp,
    /// Those of the way to the goal, from when it was written; `None` without a profile.
    limits: Option<Limits>,
    mode: i32,
    is_driven: bool,
    error: i32,
    /// Sum of the deviations of the loop, in units of its output.
    sum: f64,
    overload_ms: i32,
    silence_ms: i32,
    time_ms: i32,
    /// Added to the steps of the encoder: whole turns that were reset.
    turns: i32,
}

impl X {
    pub fn new(model: &Model, id: u8, motor: Motor) -> Self {
        let mut servo = Self {
            server: Server::new(model.table, id),
            motor,
            loop_scale: model.loop_scale,
            current_unit_a: model.current_unit_a,
            ramp: Ramp::at(0),
            limits: None,
            mode: 0,
            is_driven: false,
            error: 0,
            sum: 0.0,
            overload_ms: 0,
            silence_ms: 0,
            time_ms: 0,
            turns: 0,
        };
        servo.start();
        servo.take_commands();
        servo.publish();
        servo
    }

    fn get(&self, field: Field) -> i32 {
        self.server.memory.get(field)
    }

    fn set(&mut self, field: Field, value: i32) {
        self.server.memory.set(field, value);
    }

    fn real(&self, field: Field) -> f64 {
        f64::from(self.get(field))
    }

    /// A start: goals have their initial values.
    fn start(&mut self) {
        self.reset_turns();
        self.change_mode();
        self.is_driven = false;
        self.set(x::TORQUE_ENABLE, self.get(x::STARTUP_CONFIGURATION) & 1);
    }

    fn reset_turns(&mut self) {
        let raw = self.motor.sensed().position;
        self.turns = raw - raw.rem_euclid(TURN);
        self.hold();
    }

    /// Goals of a new mode: the limits, and the present position.
    fn change_mode(&mut self) {
        self.mode = self.get(x::OPERATING_MODE);
        self.set(
            x::GOAL_PWM,
            if self.mode == PWM_MODE {
                0
            } else {
                self.get(x::PWM_LIMIT)
            },
        );
        self.set(
            x::GOAL_CURRENT,
            if self.mode == CURRENT_MODE {
                0
            } else {
                self.get(x::CURRENT_LIMIT)
            },
        );
        self.set(
            x::GOAL_VELOCITY,
            if self.mode == VELOCITY_MODE {
                0
            } else {
                self.get(x::VELOCITY_LIMIT)
            },
        );
        self.hold();
    }

    /// The present position as the goal.
    fn hold(&mut self) {
        let position = self.position();
        self.ramp = Ramp::at(position);
        self.set(x::GOAL_POSITION, position);
        (self.error, self.sum) = (0, 0.0);
    }

    /// 1, or -1 in the reverse mode.
    fn direction(&self) -> i32 {
        if self.get(x::DRIVE_MODE) & 1 == 0 {
            1
        } else {
            -1
        }
    }

    /// The position of the table. In the position mode an offset of more than a quarter turn is
    /// ignored.
    fn position(&self) -> i32 {
        let raw = self.motor.sensed().position.wrapping_sub(self.turns);
        let turned = self.direction().wrapping_mul(raw);
        let turned = if self.mode == POSITION_MODE {
            turned.rem_euclid(TURN)
        } else {
            turned
        };
        let offset = self.get(x::HOMING_OFFSET);
        let is_ignored = self.mode == POSITION_MODE && offset.abs() > TURN / 4;
        turned + if is_ignored { 0 } else { offset }
    }

    fn rate(&self) -> f64 {
        f64::from(self.direction()) * self.motor.sensed().rate
    }

    /// Carries out a packet: what it writes is in effect before the next one.
    pub fn receive(&mut self, packet: &[u8]) -> Option<Answer> {
        let answer = self.server.receive(packet);
        match self.server.take_event() {
            Some(Event::Restart) => self.start(),
            Some(Event::ResetTurns) => self.reset_turns(),
            None => {}
        }
        self.take_commands();
        answer
    }

    /// A period of 1 ms with this supply.
    pub fn step(&mut self, supply_v: f64) {
        self.time_ms = (self.time_ms + 1) % 32_768;
        self.watch();
        let drive = if self.is_driven {
            self.drive()
        } else {
            Drive::Free
        };
        self.motor.advance(drive, supply_v);
        self.protect();
        self.publish();
    }

    /// The bus watchdog: without an instruction for its time, the servo stops.
    fn watch(&mut self) {
        self.silence_ms = if self.server.take_received() {
            0
        } else {
            self.silence_ms.saturating_add(1)
        };
        let limit = self.get(x::BUS_WATCHDOG);
        if limit > 0 && self.is_driven && self.silence_ms > 20 * limit {
            self.set(x::BUS_WATCHDOG, -1);
            self.set(x::PROFILE_ACCELERATION, 0);
            self.set(x::PROFILE_VELOCITY, 0);
            self.change_mode();
            match self.mode {
                PWM_MODE => self.set(x::GOAL_PWM, 0),
                CURRENT_MODE => self.set(x::GOAL_CURRENT, 0),
                VELOCITY_MODE => self.set(x::GOAL_VELOCITY, 0),
                _ => {}
            }
        }
    }

    fn take_commands(&mut self) {
        if self.server.memory.take_written(x::OPERATING_MODE) {
            self.change_mode();
        }
        let goals = [
            x::GOAL_PWM,
            x::GOAL_CURRENT,
            x::GOAL_VELOCITY,
            x::GOAL_POSITION,
        ];
        let has_goal = goals
            .map(|goal| self.server.memory.take_written(goal))
            .contains(&true);
        let turns_on = has_goal && self.get(x::DRIVE_MODE) & 8 != 0;
        let has_failed = self.get(x::HARDWARE_ERROR_STATUS) & self.get(x::SHUTDOWN) != 0;
        if turns_on && !has_failed {
            self.set(x::TORQUE_ENABLE, 1);
        }
        let is_driven = self.get(x::TORQUE_ENABLE) != 0;
        if is_driven && !self.is_driven {
            let goal = self.get(x::GOAL_POSITION);
            self.hold();
            // A goal that was written before the torque is in effect.
            self.set(x::GOAL_POSITION, goal);
            self.silence_ms = 0;
        }
        if has_goal || is_driven != self.is_driven {
            self.limits = self.profile();
        }
        self.is_driven = is_driven;
    }
}
