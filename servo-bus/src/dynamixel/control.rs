//! What the registers of a servo command its loop, and what the loop reports in them.
//!
//! Rules are those of the pages of emanual.robotis.com; feedforward gains have no effect.

use super::{Event, Server};
use crate::memory::Memory;
use crate::tables::x;
use crate::{Profile, TURN};

/// PWM of the whole supply.
pub const FULL_PWM: i32 = 885;

/// Deviation within which a goal is reached, steps.
const IN_POSITION: u32 = 10;

/// Bits of the hardware errors.
pub mod error {
    /// The supply is beyond its limits.
    pub const VOLTAGE: i32 = 1 << 0;
    /// The servo is too hot.
    pub const TEMPERATURE: i32 = 1 << 2;
    /// The encoder has failed.
    pub const ENCODER: i32 = 1 << 3;
    /// The electronics has failed.
    pub const SHOCK: i32 = 1 << 4;
    /// The load was too high for too long.
    pub const OVERLOAD: i32 = 1 << 5;
}

/// Mode of operation, `operating_mode`.
pub mod mode {
    /// Current.
    pub const CURRENT: i32 = 0;
    /// Velocity.
    pub const VELOCITY: i32 = 1;
    /// Position within a turn.
    pub const POSITION: i32 = 3;
    /// Position over several turns.
    pub const EXTENDED_POSITION: i32 = 4;
    /// Position with a limited current.
    pub const CURRENT_BASED_POSITION: i32 = 5;
    /// PWM.
    pub const PWM: i32 = 16;
}

/// What the registers command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Control {
    /// The mode of operation.
    pub mode: i32,
    /// The torque is on.
    pub is_driven: bool,
    /// Added to the position of the shaft: whole turns that were reset.
    turns: i32,
    /// Time without an instruction, ms.
    silence_ms: i32,
    time_ms: i32,
}

/// What the loop has to do for what was taken from the registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Taken {
    /// The trajectory to the goal begins at the present position, at rest.
    pub begins: bool,
    /// The servo was restarted, which acknowledges its errors.
    pub restarts: bool,
    /// A goal was written, or the torque turned on: its profile begins.
    pub has_goal: bool,
    /// The torque was written.
    pub has_torque: bool,
}

impl Taken {
    /// With what was taken from another packet.
    pub fn add(&mut self, other: Self) {
        self.begins |= other.begins;
        self.restarts |= other.restarts;
        self.has_goal |= other.has_goal;
        self.has_torque |= other.has_torque;
    }
}

/// What the loop measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Measured {
    /// Position of the shaft over all turns, steps.
    pub shaft: i32,
    /// Rate of the shaft, in units of the table.
    pub rate: i32,
    /// PWM in the direction of the shaft.
    pub pwm: i32,
    /// Current in the direction of the shaft, in units of the table.
    pub current: i32,
    /// Supply, 0.1 V.
    pub voltage: i32,
    /// degC.
    pub temperature: i32,
    /// Position and velocity of the trajectory to the goal, in units of the table.
    pub trajectory: (i32, i32),
    /// Bits of [`error`] that are present.
    pub errors: i32,
}

impl Control {
    /// After a start, with the shaft at this position.
    pub fn new(memory: &mut Memory, shaft: i32) -> Self {
        let mut control = Self::default();
        control.start(memory, shaft);
        control.take_written(memory, shaft);
        control
    }

    fn start(&mut self, memory: &mut Memory, shaft: i32) {
        self.reset_turns(memory, shaft);
        self.change_mode(memory, shaft);
        self.is_driven = false;
        memory.set(x::TORQUE_ENABLE, memory.get(x::STARTUP_CONFIGURATION) & 1);
    }

    fn reset_turns(&mut self, memory: &mut Memory, shaft: i32) {
        self.turns = shaft - shaft.rem_euclid(TURN);
        self.hold(memory, shaft);
    }

    /// Goals of a new mode: the limits, and the present position.
    fn change_mode(&mut self, memory: &mut Memory, shaft: i32) {
        self.mode = memory.get(x::OPERATING_MODE);
        for (goal, limit, of_mode) in [
            (x::GOAL_PWM, x::PWM_LIMIT, mode::PWM),
            (x::GOAL_CURRENT, x::CURRENT_LIMIT, mode::CURRENT),
            (x::GOAL_VELOCITY, x::VELOCITY_LIMIT, mode::VELOCITY),
        ] {
            let limit = memory.get(limit);
            memory.set(goal, if self.mode == of_mode { 0 } else { limit });
        }
        self.hold(memory, shaft);
    }

    /// Makes the present position the goal.
    pub fn hold(&self, memory: &mut Memory, shaft: i32) {
        memory.set(x::GOAL_POSITION, self.position(memory, shaft));
    }

    /// 1, or -1 in the reverse mode.
    pub fn direction(memory: &Memory) -> i32 {
        1 - 2 * (memory.get(x::DRIVE_MODE) & 1)
    }

    /// The position of the table for this one of the shaft. In the position mode an offset of more
    /// than a quarter turn is ignored.
    pub fn position(&self, memory: &Memory, shaft: i32) -> i32 {
        let turned = Self::direction(memory).wrapping_mul(shaft.wrapping_sub(self.turns));
        let offset = memory.get(x::HOMING_OFFSET);
        if self.mode != mode::POSITION {
            return turned.wrapping_add(offset);
        }
        let is_ignored = offset.abs() > TURN / 4;
        turned.rem_euclid(TURN) + if is_ignored { 0 } else { offset }
    }

    /// Takes what the last packet has written. To be called behind each packet, so that what it
    /// writes is in effect before the next one.
    pub fn take(&mut self, server: &mut Server, shaft: i32) -> Taken {
        let event = server.take_event();
        if server.take_received() {
            self.silence_ms = 0;
        }
        let memory = &mut server.memory;
        match event {
            Some(Event::Restart) => self.start(memory, shaft),
            Some(Event::ResetTurns) => self.reset_turns(memory, shaft),
            None => {}
        }
        let mut taken = self.take_written(memory, shaft);
        taken.begins |= event.is_some();
        taken.restarts = event == Some(Event::Restart);
        taken
    }

    fn take_written(&mut self, memory: &mut Memory, shaft: i32) -> Taken {
        let mut taken = Taken {
            has_torque: memory.take_written(x::TORQUE_ENABLE),
            ..Taken::default()
        };
        if memory.take_written(x::OPERATING_MODE) {
            self.change_mode(memory, shaft);
            taken.begins = true;
        }
        let goals = [
            x::GOAL_PWM,
            x::GOAL_CURRENT,
            x::GOAL_VELOCITY,
            x::GOAL_POSITION,
        ];
        taken.has_goal = goals.map(|it| memory.take_written(it)).contains(&true);
        let turns_on = taken.has_goal && memory.get(x::DRIVE_MODE) & 8 != 0;
        let errors = memory.get(x::HARDWARE_ERROR_STATUS);
        if turns_on && errors & memory.get(x::SHUTDOWN) == 0 {
            memory.set(x::TORQUE_ENABLE, 1);
        }
        let is_driven = memory.get(x::TORQUE_ENABLE) != 0;
        let was_driven = core::mem::replace(&mut self.is_driven, is_driven);
        if is_driven && !was_driven {
            // A goal that was written before the torque is in effect.
            taken.begins = true;
            self.silence_ms = 0;
        }
        taken.has_goal |= is_driven != was_driven;
        taken
    }

    /// Time passes. The bus watchdog stops a servo that has received no instruction for its time;
    /// returns whether it did now.
    pub fn elapse(&mut self, memory: &mut Memory, ms: i32, shaft: i32) -> bool {
        self.time_ms = (self.time_ms + ms) % 32_768;
        self.silence_ms = self.silence_ms.saturating_add(ms);
        let limit = memory.get(x::BUS_WATCHDOG);
        let expires = limit > 0 && self.is_driven && self.silence_ms > 20 * limit;
        if expires {
            memory.set(x::BUS_WATCHDOG, -1);
            memory.set(x::PROFILE_ACCELERATION, 0);
            memory.set(x::PROFILE_VELOCITY, 0);
            self.change_mode(memory, shaft);
        }
        expires
    }

    /// Bits of [`error`] for a supply, in 0.1 V, or a temperature, in degC, out of its range.
    pub fn out_of_range(memory: &Memory, voltage: i32, temperature: i32) -> i32 {
        let (least, most) = (
            memory.get(x::MIN_VOLTAGE_LIMIT),
            memory.get(x::MAX_VOLTAGE_LIMIT),
        );
        let is_out = !(least..=most).contains(&voltage);
        let is_hot = temperature > memory.get(x::TEMPERATURE_LIMIT);
        let bit = |is_set: bool, bit: i32| if is_set { bit } else { 0 };
        bit(is_hot, error::TEMPERATURE) | bit(is_out, error::VOLTAGE)
    }

    /// Turns the torque off, which an error may do.
    pub fn turn_off(&mut self, memory: &mut Memory) {
        memory.set(x::TORQUE_ENABLE, 0);
        self.is_driven = false;
    }

    /// Limits of the trajectory to the goal, which begins with this distance and velocity, in steps
    /// and steps/s; `None` without a profile.
    pub fn profile(&self, memory: &Memory, distance: u32, velocity: i32) -> Option<Profile> {
        let of = |field| memory.get(field).unsigned_abs();
        let (most, acceleration) = (of(x::PROFILE_VELOCITY), of(x::PROFILE_ACCELERATION));
        let is_timed = memory.get(x::DRIVE_MODE) & 4 != 0;
        let (velocity, acceleration) = match (self.mode, is_timed) {
            (mode::VELOCITY, false) => (u32::MAX, acceleration_steps(acceleration)),
            (mode::VELOCITY, true) => {
                let change = Self::goal_velocity(memory).abs_diff(velocity);
                (u32::MAX, rate(change, acceleration))
            }
            _ if most == 0 => return None,
            (_, false) => (velocity_steps(most), acceleration_steps(acceleration)),
            // Of a motion from rest that accelerates for half of its time at most.
            (_, true) => {
                let ramp_ms = acceleration.min(most / 2);
                let velocity = rate(distance, most - ramp_ms);
                (velocity, rate(velocity, ramp_ms))
            }
        };
        Some(Profile {
            // A fraction of a limit does not end the motion.
            velocity: velocity.max(1),
            acceleration: if acceleration == 0 {
                u32::MAX
            } else {
                acceleration
            },
        })
    }

    /// The goal of the velocity mode, steps/s.
    pub fn goal_velocity(memory: &Memory) -> i32 {
        let goal = i64::from(memory.get(x::GOAL_VELOCITY)) * STEPS_S.0;
        // Rounded half away from zero; within 2^31.
        ((goal + goal.signum() * STEPS_S.1 / 2) / STEPS_S.1) as i32
    }

    /// A rate in units of the table, of steps/s.
    pub fn velocity_units(steps_s: i32) -> i32 {
        let units = i64::from(steps_s) * STEPS_S.1;
        // A smaller number.
        ((units + units.signum() * STEPS_S.0 / 2) / STEPS_S.0) as i32
    }

    /// Reports what the loop measures. An error for which the table shuts down turns the torque
    /// off.
    pub fn report(&mut self, memory: &mut Memory, measured: &Measured) {
        let errors = memory.get(x::HARDWARE_ERROR_STATUS) | measured.errors;
        memory.set(x::HARDWARE_ERROR_STATUS, errors);
        if errors & memory.get(x::SHUTDOWN) != 0 {
            self.turn_off(memory);
        }
        let forward = Self::direction(memory);
        let position = self.position(memory, measured.shaft);
        let rate = forward * measured.rate;
        let current = forward * measured.current;
        memory.set(x::PRESENT_POSITION, position);
        memory.set(x::PRESENT_VELOCITY, rate);
        memory.set(x::PRESENT_PWM, forward * measured.pwm);
        memory.set(x::PRESENT_CURRENT, current.clamp(-32_768, 32_767));
        memory.set(x::PRESENT_INPUT_VOLTAGE, measured.voltage.clamp(0, 65_535));
        memory.set(x::PRESENT_TEMPERATURE, measured.temperature.clamp(0, 255));
        memory.set(x::REALTIME_TICK, self.time_ms);
        let threshold = memory.get(x::MOVING_THRESHOLD);
        memory.set(x::MOVING, i32::from(rate.abs() > threshold));
        memory.set(x::POSITION_TRAJECTORY, measured.trajectory.0);
        memory.set(x::VELOCITY_TRAJECTORY, measured.trajectory.1);
        let goal = memory.get(x::GOAL_POSITION);
        let is_there = position.abs_diff(goal) <= IN_POSITION;
        let is_under_way = self.is_driven && measured.trajectory.0 != goal;
        let status = i32::from(is_there) | i32::from(is_under_way) << 1;
        memory.set(x::MOVING_STATUS, status);
    }
}

/// Velocity of one, 0.229 rev/min, in steps/s: a fraction.
const STEPS_S: (i64, i64) = (229 * TURN as i64, 60_000);

/// Acceleration of one, 214.577 rev/min^2, in steps/s^2: a fraction.
const STEPS_S2: (u64, u64) = (214_577 * TURN as u64, 3_600_000);

/// Rounded up; registers have 15 bits.
fn velocity_steps(units: u32) -> u32 {
    (u64::from(units) * STEPS_S.0 as u64).div_ceil(STEPS_S.1 as u64) as u32
}

/// Rounded up; registers have 15 bits.
fn acceleration_steps(units: u32) -> u32 {
    (u64::from(units) * STEPS_S2.0).div_ceil(STEPS_S2.1) as u32
}

/// A change in a time, per s, rounded up; 0 without a time.
fn rate(change: u32, ms: u32) -> u32 {
    if ms == 0 {
        return 0;
    }
    let rate = (u64::from(change) * 1000).div_ceil(ms.into());
    rate.min(u32::MAX.into()) as u32
}
