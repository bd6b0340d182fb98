//! The loop of a Dynamixel of the X series.
//!
//! What the pages of emanual.robotis.com leave open is an assumption: gains count periods of 1 ms;
//! the current loop is ideal; an overload is an output of 80 % or more without motion for 1 s.

mod control;
mod report;

use canopen::cia402::{Limits, Ramp};
use servo_bus::dynamixel::{self, Control, Server, Taken};
use servo_bus::{Answer, Field, TURN, tables::x};

use super::motor::{Drive, Motor};
use super::{Model, PERIOD_US};

/// PWM of the whole supply.
const FULL_PWM: f64 = dynamixel::FULL_PWM as f64;

/// Velocity of one, 0.229 rev/min, in steps/s.
const VELOCITY_UNIT: f64 = 0.229 * TURN as f64 / 60.0;

/// A servo of the X series.
#[derive(Debug)]
pub struct X {
    pub server: Server,
    pub motor: Motor,
    loop_scale: f64,
    current_unit_a: f64,
    control: Control,
    ramp: Ramp<PERIOD_US>,
    /// Those of the trajectory to the goal, from when it was written; `None` without a profile.
    limits: Option<Limits>,
    error: i32,
    /// Sum of the deviations of the loop, in units of its output.
    sum: f64,
    overload_ms: i32,
}

impl X {
    pub fn new(model: &Model, id: u8, motor: Motor) -> Self {
        let mut server = Server::new(model.table, id);
        let control = Control::new(&mut server.memory, motor.sensed().position);
        let mut servo = Self {
            server,
            motor,
            loop_scale: model.loop_scale,
            current_unit_a: model.current_unit_a(),
            control,
            ramp: Ramp::at(0),
            limits: None,
            error: 0,
            sum: 0.0,
            overload_ms: 0,
        };
        servo.begin();
        servo.publish();
        servo
    }

    fn get(&self, field: Field) -> i32 {
        self.server.memory.get(field)
    }

    fn real(&self, field: Field) -> f64 {
        f64::from(self.get(field))
    }

    /// The trajectory to the goal begins at the present position.
    fn begin(&mut self) {
        self.ramp = Ramp::at(self.position());
        (self.error, self.sum) = (0, 0.0);
    }

    /// 1, or -1 in the reverse mode.
    fn direction(&self) -> i32 {
        Control::direction(&self.server.memory)
    }

    /// The position of the table.
    fn position(&self) -> i32 {
        let shaft = self.motor.sensed().position;
        self.control.position(&self.server.memory, shaft)
    }

    fn rate(&self) -> f64 {
        f64::from(self.direction()) * self.motor.sensed().rate
    }

    /// Carries out a packet: what it writes is in effect before the next one.
    pub fn receive(&mut self, packet: &[u8]) -> Option<Answer> {
        let answer = self.server.receive(packet);
        let shaft = self.motor.sensed().position;
        let Taken {
            begins, has_goal, ..
        } = self.control.take(&mut self.server, shaft);
        if begins {
            self.begin();
        }
        if has_goal {
            let distance = self.ramp.position().abs_diff(self.get(x::GOAL_POSITION));
            let velocity = self.ramp.velocity();
            let profile = (self.control).profile(&self.server.memory, distance, velocity);
            self.limits = profile.map(|it| Limits {
                velocity: it.velocity,
                acceleration: it.acceleration,
                deceleration: it.acceleration,
            });
        }
        answer
    }

    /// A period of 1 ms with this supply.
    pub fn step(&mut self, supply_v: f64) {
        let shaft = self.motor.sensed().position;
        if self.control.elapse(&mut self.server.memory, 1, shaft) {
            self.begin();
        }
        let drive = if self.control.is_driven {
            self.drive()
        } else {
            Drive::Free
        };
        self.motor.advance(drive, supply_v);
        self.publish();
    }
}
