//! The trajectory of the shaft to a goal, mdeg.

use canopen::cia402::{Limits, Ramp};

use super::PERIOD_US;
use super::motor::{Sensed, Target};

/// A trajectory and its end.
#[derive(Debug)]
pub(super) struct Trajectory {
    ramp: Ramp<PERIOD_US>,
    /// Its end.
    pub goal: i32,
}

impl Trajectory {
    /// At rest at this position.
    pub fn at(position: i32) -> Self {
        Self {
            ramp: Ramp::at(position),
            goal: position,
        }
    }

    /// Begins at rest where the shaft is.
    pub fn begin(&mut self, sensed: &Sensed) {
        self.ramp = Ramp::at(sensed.position_mdeg);
    }

    /// Its position.
    pub fn position(&self) -> i32 {
        self.ramp.position()
    }

    /// Its velocity, mdeg/s.
    pub fn velocity(&self) -> i32 {
        self.ramp.velocity()
    }

    /// Continues for so many control periods to its end, no further from the shaft than is
    /// permitted: a shaft that is held back with a limited torque, as a grip, is no fault.
    pub fn continue_to_goal(&mut self, limits: &Limits, sensed: &Sensed, periods: u32) -> Target {
        for _ in 0..periods {
            self.ramp.to_position(self.goal, limits);
        }
        if let Some(room) = sensed.room_mdeg {
            let ahead = self.position().saturating_sub(sensed.position_mdeg);
            let reachable = ahead.max(-room).min(room);
            if reachable != ahead {
                self.ramp = Ramp::at(sensed.position_mdeg.saturating_add(reachable));
            }
        }
        Target::Position(self.position())
    }

    /// Continues for so many control periods with this velocity in the end, mdeg/s.
    pub fn continue_at(&mut self, velocity: i32, limits: &Limits, periods: u32) -> Target {
        for _ in 0..periods {
            self.ramp.to_velocity(velocity, limits);
        }
        Target::Velocity(self.velocity())
    }
}
