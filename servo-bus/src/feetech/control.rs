//! What the registers of a servo command its loop, and what the loop reports in them.
//!
//! Rules that the memory table states are its. What it leaves open is an assumption: an overload
//! ends when the torque is written or a new goal leads the load back; a write of a goal turns the
//! torque on; an increment of the step mode is added to the goal.

use super::{Event, Server};
use crate::memory::Memory;
use crate::tables::sts;
use crate::{MIDDLE, Profile, TURN};

/// Speed of one in the limits of speeds, steps/s.
pub const SPEED_UNIT: i32 = 50;

/// Acceleration of one, steps/s^2.
pub const ACCELERATION_UNIT: u32 = 100;

/// Bits of the status.
pub mod status {
    /// The supply is beyond its limits.
    pub const VOLTAGE: i32 = 1 << 0;
    /// The encoder has failed.
    pub const ENCODER: i32 = 1 << 1;
    /// The servo is too hot.
    pub const TEMPERATURE: i32 = 1 << 2;
    /// The current was too high for too long.
    pub const CURRENT: i32 = 1 << 3;
    /// The load was too high for too long.
    pub const OVERLOAD: i32 = 1 << 5;
}

/// Mode of operation, `operating_mode`.
pub mod mode {
    /// Position within a turn, or over several if both limits are 0.
    pub const POSITION: i32 = 0;
    /// Speed.
    pub const WHEEL: i32 = 1;
    /// Duty.
    pub const PWM: i32 = 2;
    /// Increments of the position.
    pub const STEP: i32 = 3;
}

/// What the registers command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Control {
    /// The goal that is in effect, steps of the table.
    pub goal: i32,
    /// 0 free, 1 on, 2 braked.
    pub torque: i32,
    /// The mode of operation.
    pub mode: i32,
    /// Added to the position of the shaft: whole turns that were reset.
    turns: i32,
}

/// What the loop has to do for what was taken from the registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Taken {
    /// The trajectory to the goal begins at the present position, at rest.
    pub begins: bool,
    /// What ended or weakened the torque is acknowledged.
    pub acknowledges: bool,
    /// A goal was written, which acknowledges an overload.
    pub has_goal: bool,
}

impl Taken {
    /// With what was taken from another packet.
    pub fn add(&mut self, other: Self) {
        self.begins |= other.begins;
        self.acknowledges |= other.acknowledges;
        self.has_goal |= other.has_goal;
    }
}

/// What the loop measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Measured {
    /// Position of the shaft over all turns, steps.
    pub shaft: i32,
    /// Steps/s.
    pub rate: i32,
    /// Duty, 0.1 %.
    pub load_permille: i32,
    /// Supply, 0.1 V.
    pub voltage: i32,
    /// degC.
    pub temperature: i32,
    /// Current in units of the table.
    pub current: i32,
    /// Bits of [`status`].
    pub status: i32,
    /// The trajectory to the goal has not ended.
    pub is_under_way: bool,
}

impl Control {
    /// After a start, with the shaft at this position.
    pub fn new(memory: &mut Memory, shaft: i32) -> Self {
        let mut control = Self::default();
        control.start(memory, shaft);
        control
    }

    fn start(&mut self, memory: &mut Memory, shaft: i32) {
        memory.set(sts::TORQUE_LIMIT, memory.get(sts::MAX_TORQUE_LIMIT));
        (self.torque, self.mode) = (0, memory.get(sts::OPERATING_MODE));
        self.hold(memory, shaft);
        memory.set(sts::GOAL_POSITION, self.goal);
    }

    /// Makes the present position the goal.
    pub fn hold(&mut self, memory: &Memory, shaft: i32) {
        self.goal = self.position(memory, shaft);
    }

    /// The position of the table for this one of the shaft.
    pub fn position(&self, memory: &Memory, shaft: i32) -> i32 {
        let offset = memory.get(sts::HOMING_OFFSET);
        let position = shaft.wrapping_sub(self.turns).wrapping_sub(offset);
        if self.has_turns(memory) {
            position
        } else {
            position.rem_euclid(TURN)
        }
    }

    /// Whether positions count turns.
    fn has_turns(&self, memory: &Memory) -> bool {
        let limits = [sts::MIN_POSITION_LIMIT, sts::MAX_POSITION_LIMIT].map(|it| memory.get(it));
        self.mode == mode::STEP || limits == [0, 0]
    }

    /// Takes what the last packet has written. To be called behind each packet, so that what it
    /// writes is in effect before the next one.
    pub fn take(&mut self, server: &mut Server, shaft: i32) -> Taken {
        let event = server.take_event();
        let memory = &mut server.memory;
        match event {
            Some(Event::Restart) => self.start(memory, shaft),
            Some(Event::ResetTurns) => {
                self.turns = shaft - shaft.rem_euclid(TURN);
                self.hold(memory, shaft);
            }
            Some(Event::Calibrate(position)) => self.calibrate(memory, shaft, position),
            None => return self.take_written(memory, shaft),
        }
        Taken {
            begins: true,
            acknowledges: event == Some(Event::Restart),
            has_goal: false,
        }
    }

    /// Makes the present position this one, as far as the offset's range reaches: from the seam it
    /// lacks one step.
    fn calibrate(&mut self, memory: &mut Memory, shaft: i32, position: i32) {
        let raw = shaft.rem_euclid(TURN);
        let offset = (raw - position + MIDDLE).rem_euclid(TURN) - MIDDLE;
        memory.store(sts::HOMING_OFFSET, offset.max(1 - MIDDLE));
        self.hold(memory, shaft);
    }

    fn take_written(&mut self, memory: &mut Memory, shaft: i32) -> Taken {
        let mut taken = Taken::default();
        if memory.take_written(sts::TORQUE_ENABLE) {
            taken.acknowledges = true;
            match memory.get(sts::TORQUE_ENABLE) {
                128 => {
                    self.calibrate(memory, shaft, MIDDLE);
                    memory.set(sts::TORQUE_ENABLE, self.torque);
                    taken.begins = true;
                }
                1 => taken.begins |= self.turn_on(memory),
                other => self.torque = other,
            }
        }
        if memory.get(sts::OPERATING_MODE) != self.mode {
            self.mode = memory.get(sts::OPERATING_MODE);
            self.hold(memory, shaft);
            taken.begins = true;
        }
        let has_goals = matches!(self.mode, mode::POSITION | mode::STEP);
        if memory.take_written(sts::GOAL_POSITION) && has_goals {
            let goal = memory.get(sts::GOAL_POSITION);
            self.goal = if self.mode == mode::STEP {
                self.goal.saturating_add(goal)
            } else {
                self.limited(memory, goal)
            };
            taken.has_goal = true;
            taken.begins |= self.turn_on(memory);
        }
        taken
    }

    /// Turns the torque on; returns whether it was not.
    fn turn_on(&mut self, memory: &mut Memory) -> bool {
        memory.set(sts::TORQUE_ENABLE, 1);
        core::mem::replace(&mut self.torque, 1) != 1
    }

    /// Turns the torque off, which an error may do.
    pub fn turn_off(&mut self, memory: &mut Memory) {
        memory.set(sts::TORQUE_ENABLE, 0);
        self.torque = 0;
    }

    fn limited(&self, memory: &Memory, goal: i32) -> i32 {
        let limits = [sts::MIN_POSITION_LIMIT, sts::MAX_POSITION_LIMIT].map(|it| memory.get(it));
        let [one, other] = limits;
        if self.has_turns(memory) {
            goal
        } else {
            goal.max(one.min(other)).min(one.max(other))
        }
    }

    /// Bits of [`status`] for a supply, in 0.1 V, or a temperature, in degC, out of its range.
    pub fn out_of_range(memory: &Memory, voltage: i32, temperature: i32) -> i32 {
        let (least, most) = (
            memory.get(sts::MIN_VOLTAGE_LIMIT),
            memory.get(sts::MAX_VOLTAGE_LIMIT),
        );
        let is_out = !(least..=most).contains(&voltage);
        let is_hot = temperature > memory.get(sts::MAX_TEMPERATURE_LIMIT);
        let bit = |is_set: bool, bit: i32| if is_set { bit } else { 0 };
        bit(is_hot, status::TEMPERATURE) | bit(is_out, status::VOLTAGE)
    }

    /// Greatest speed, steps/s.
    pub fn greatest_speed(memory: &Memory) -> i32 {
        SPEED_UNIT * memory.get(sts::MAXIMUM_VELOCITY_LIMIT)
    }

    /// Limits of the trajectory to a goal.
    pub fn profile(memory: &Memory) -> Profile {
        let most = Self::greatest_speed(memory);
        let wanted = memory.get(sts::GOAL_VELOCITY).abs();
        let velocity = if wanted == 0 { most } else { wanted.min(most) };
        let acceleration = match memory.get(sts::ACCELERATION) {
            0 => u32::MAX,
            wanted => {
                let most = memory.get(sts::MAXIMUM_ACCELERATION).max(1);
                ACCELERATION_UNIT * wanted.min(most) as u32
            }
        };
        Profile {
            velocity: velocity as u32,
            acceleration,
        }
    }

    /// Speed of the wheel mode, steps/s.
    pub fn speed(memory: &Memory) -> i32 {
        let most = Self::greatest_speed(memory);
        memory.get(sts::GOAL_VELOCITY).max(-most).min(most)
    }

    /// Reports what the loop measures.
    pub fn report(&self, memory: &mut Memory, measured: &Measured) {
        let position = self.position(memory, measured.shaft);
        let shown = if self.mode == mode::STEP {
            self.goal.wrapping_sub(position)
        } else {
            position
        };
        let signed = |value: i32| value.clamp(-32_767, 32_767);
        memory.set(sts::PRESENT_POSITION, signed(shown));
        memory.set(sts::PRESENT_VELOCITY, signed(measured.rate));
        memory.set(sts::PRESENT_LOAD, measured.load_permille.clamp(-1000, 1000));
        memory.set(sts::PRESENT_VOLTAGE, measured.voltage.clamp(0, 255));
        memory.set(sts::PRESENT_TEMPERATURE, measured.temperature.clamp(0, 255));
        memory.set(sts::PRESENT_CURRENT, signed(measured.current));
        memory.set(sts::STATUS, measured.status);
        memory.set(sts::GOAL_POSITION_IN_EFFECT, signed(self.goal));
        let has_goals = matches!(self.mode, mode::POSITION | mode::STEP);
        let is_under_way = self.torque == 1 && has_goals && measured.is_under_way;
        let threshold = SPEED_UNIT * memory.get(sts::MOVING_THRESHOLD);
        let is_moving = is_under_way || measured.rate.abs() > threshold;
        memory.set(sts::MOVING, i32::from(is_moving));
    }
}
