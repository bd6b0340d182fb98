//! What the table of a Dynamixel of the X series commands.
//!
//! Rules are those of the pages of emanual.robotis.com. What they leave open is an assumption: gains
//! count periods of 1 ms; the current loop is ideal; an overload is an output of 80 % or more without
//! motion for 1 s; feedforward gains have no effect.

use canopen::cia402::{Limits, Ramp};
use servo_bus::dynamixel::{Event, Server};
use servo_bus::{Answer, Field, tables::x};

use super::Model;
use super::motor::{Drive, Motor, TURN};

const PERIOD_US: u32 = 1000;

/// Bits of the hardware errors.
const VOLTAGE: i32 = 1;
const TEMPERATURE: i32 = 4;
const OVERLOAD: i32 = 32;

/// PWM of the whole supply.
const FULL_PWM: f64 = 885.0;

/// Velocity of one, 0.229 rev/min, in steps/s.
const VELOCITY_UNIT: f64 = 0.229 * TURN as f64 / 60.0;

/// Acceleration of one, 214.577 rev/min^2, in steps/s^2.
const ACCELERATION_UNIT: f64 = 214.577 * TURN as f64 / 3600.0;

/// Output from which an overload counts, and for how long, ms.
const OVERLOAD_DUTY: f64 = 0.8;
const OVERLOAD_MS: i32 = 1000;

/// Deviation within which a goal is reached, steps.
const IN_POSITION: i32 = 10;

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
        let raw = if self.mode == POSITION_MODE {
            raw.rem_euclid(TURN)
        } else {
            raw
        };
        let offset = self.get(x::HOMING_OFFSET);
        let is_ignored = self.mode == POSITION_MODE && offset.abs() > TURN / 4;
        self.direction() * raw + if is_ignored { 0 } else { offset }
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
        self.is_driven = is_driven;
    }

    fn drive(&mut self) -> Drive {
        let forward = f64::from(self.direction());
        let most = self.real(x::GOAL_PWM).abs() / FULL_PWM;
        let most_current = self.real(x::GOAL_CURRENT);
        let duty = match self.mode {
            PWM_MODE => self.real(x::GOAL_PWM) / FULL_PWM,
            CURRENT_MODE => {
                return Drive::Current(forward * most_current * self.current_unit_a, most);
            }
            VELOCITY_MODE => self.velocity_duty(),
            mode => {
                let output = self.position_output();
                if mode == CURRENT_POSITION_MODE {
                    let current = output.clamp(-most_current.abs(), most_current.abs());
                    return Drive::Current(forward * current * self.current_unit_a, most);
                }
                self.loop_scale * output / FULL_PWM
            }
        };
        Drive::Duty(forward * duty.clamp(-most, most))
    }

    /// Output of the PID on the position, in its units.
    fn position_output(&mut self) -> f64 {
        let goal = self.get(x::GOAL_POSITION);
        match self.profile(goal) {
            Some(limits) => drop(self.ramp.to_position(goal, &limits, PERIOD_US)),
            None => self.ramp = Ramp::at(goal),
        }
        let error = self.ramp.position().wrapping_sub(self.position());
        let change = error - std::mem::replace(&mut self.error, error);
        let gain = |field, share: f64| self.real(field) / share;
        let i = gain(x::POSITION_I_GAIN, 65_536.0);
        // Without effect above the range of the output.
        let sum = (self.sum + i * f64::from(error)).clamp(-FULL_PWM, FULL_PWM);
        let output = gain(x::POSITION_P_GAIN, 128.0) * f64::from(error)
            + sum
            + gain(x::POSITION_D_GAIN, 16.0) * f64::from(change);
        self.sum = sum;
        output
    }

    /// Limits of the way to a goal; `None` without a profile.
    fn profile(&self, goal: i32) -> Option<Limits> {
        let (velocity, acceleration) = (
            self.real(x::PROFILE_VELOCITY),
            self.real(x::PROFILE_ACCELERATION),
        );
        if velocity == 0.0 {
            return None;
        }
        let is_timed = self.get(x::DRIVE_MODE) & 4 != 0;
        let (velocity, acceleration) = if is_timed {
            self.timed(goal, velocity, acceleration)
        } else {
            (velocity * VELOCITY_UNIT, acceleration * ACCELERATION_UNIT)
        };
        // A fraction of a limit does not end the motion.
        let velocity = velocity.ceil().max(1.0) as u32;
        let acceleration = if acceleration == 0.0 {
            u32::MAX
        } else {
            acceleration.ceil().max(1.0) as u32
        };
        Some(Limits {
            velocity,
            acceleration,
            deceleration: acceleration,
        })
    }

    /// Greatest velocity and acceleration of a motion that lasts a time and accelerates for another
    /// one, at most half of it, ms.
    fn timed(&self, goal: i32, time_ms: f64, acceleration_ms: f64) -> (f64, f64) {
        let way = f64::from(goal.wrapping_sub(self.position())).abs();
        let ramp_ms = acceleration_ms.min(time_ms / 2.0);
        let velocity = way / (time_ms - ramp_ms) * 1e3;
        let acceleration = if ramp_ms > 0.0 {
            velocity / ramp_ms * 1e3
        } else {
            0.0
        };
        (velocity, acceleration)
    }

    /// Duty of the PI on the velocity.
    fn velocity_duty(&mut self) -> f64 {
        let goal = (self.real(x::GOAL_VELOCITY) * VELOCITY_UNIT).round() as i32;
        let acceleration = self.real(x::PROFILE_ACCELERATION) * ACCELERATION_UNIT;
        let acceleration = if acceleration == 0.0 {
            u32::MAX
        } else {
            acceleration.ceil() as u32
        };
        let limits = Limits {
            velocity: u32::MAX,
            acceleration,
            deceleration: acceleration,
        };
        self.ramp.to_velocity(goal, &limits, PERIOD_US);
        let error = (f64::from(self.ramp.velocity()) - self.rate()) / VELOCITY_UNIT;
        let i = self.real(x::VELOCITY_I_GAIN) / 65_536.0;
        self.sum = (self.sum + i * error).clamp(-FULL_PWM, FULL_PWM);
        (self.real(x::VELOCITY_P_GAIN) / 128.0 * error + self.sum) / FULL_PWM
    }

    fn protect(&mut self) {
        let sensed = *self.motor.sensed();
        let volts = sensed.supply_v * 10.0;
        let is_out =
            volts < self.real(x::MIN_VOLTAGE_LIMIT) || volts > self.real(x::MAX_VOLTAGE_LIMIT);
        let is_hot = sensed.temperature_c > self.real(x::TEMPERATURE_LIMIT);
        let is_at_rest = sensed.rate.abs() < self.real(x::MOVING_THRESHOLD) * VELOCITY_UNIT;
        let is_loaded = sensed.duty.abs() >= OVERLOAD_DUTY && is_at_rest;
        self.overload_ms = if is_loaded {
            self.overload_ms.saturating_add(1)
        } else {
            0
        };
        let bits = [
            (is_out, VOLTAGE),
            (is_hot, TEMPERATURE),
            (self.overload_ms > OVERLOAD_MS, OVERLOAD),
        ];
        let present = bits
            .iter()
            .filter(|(is_set, _)| *is_set)
            .fold(0, |all, (_, bit)| all | bit);
        let errors = self.get(x::HARDWARE_ERROR_STATUS) | present;
        self.set(x::HARDWARE_ERROR_STATUS, errors);
        if errors & self.get(x::SHUTDOWN) != 0 {
            self.set(x::TORQUE_ENABLE, 0);
            self.is_driven = false;
        }
    }

    fn publish(&mut self) {
        let (sensed, position, forward) = (
            *self.motor.sensed(),
            self.position(),
            f64::from(self.direction()),
        );
        let rate = (self.rate() / VELOCITY_UNIT).round() as i32;
        self.set(x::PRESENT_POSITION, position);
        self.set(x::PRESENT_VELOCITY, rate);
        self.set(
            x::PRESENT_PWM,
            (forward * sensed.duty * FULL_PWM).round() as i32,
        );
        let current = (forward * sensed.current_a / self.current_unit_a).round() as i32;
        self.set(x::PRESENT_CURRENT, current.clamp(-32_768, 32_767));
        self.set(
            x::PRESENT_INPUT_VOLTAGE,
            (sensed.supply_v * 10.0).round() as i32,
        );
        self.set(x::PRESENT_TEMPERATURE, sensed.temperature_c.round() as i32);
        self.set(x::REALTIME_TICK, self.time_ms);
        self.set(
            x::MOVING,
            i32::from(rate.abs() > self.get(x::MOVING_THRESHOLD)),
        );
        self.set(x::POSITION_TRAJECTORY, self.ramp.position());
        self.set(
            x::VELOCITY_TRAJECTORY,
            (f64::from(self.ramp.velocity()) / VELOCITY_UNIT).round() as i32,
        );
        let goal = self.get(x::GOAL_POSITION);
        let is_there = position.abs_diff(goal) <= IN_POSITION as u32;
        let is_under_way = self.is_driven && self.ramp.position() != goal;
        self.set(
            x::MOVING_STATUS,
            i32::from(is_there) | i32::from(is_under_way) << 1,
        );
    }
}
