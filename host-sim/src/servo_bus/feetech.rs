//! The loop of an STS servo.
//!
//! The wheel mode's gains are those of `WHEEL_P` and `WHEEL_I`: an assumption, as the
//! memory table has no scale.

mod control;
mod report;

use canopen::cia402::Ramp;
use servo_bus::feetech::{Control, Server, Taken, status};
use servo_bus::{Answer, Field};

use super::motor::Motor;
use super::{Model, PERIOD_US};

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
    control: Control,
    /// The trajectory to the goal.
    ramp: Ramp<PERIOD_US>,
    error: i32,
    wheel_duty: f64,
    overload: Timer,
    overcurrent: Timer,
    /// Latched bits of the status.
    latched: i32,
}

impl Sts {
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
            error: 0,
            wheel_duty: 0.0,
            overload: Timer::default(),
            overcurrent: Timer::default(),
            latched: 0,
        };
        servo.begin();
        servo.publish();
        servo
    }

    fn get(&self, field: Field) -> i32 {
        self.server.memory.get(field)
    }

    /// The trajectory to the goal begins at the present position.
    fn begin(&mut self) {
        self.ramp = Ramp::at(self.position());
        (self.error, self.wheel_duty) = (0, 0.0);
    }

    /// The position of the table.
    fn position(&self) -> i32 {
        let shaft = self.motor.sensed().position;
        self.control.position(&self.server.memory, shaft)
    }

    /// Carries out a packet: what it writes is in effect before the next one.
    pub fn receive(&mut self, packet: &[u8]) -> Option<Answer> {
        let answer = self.server.receive(packet);
        let shaft = self.motor.sensed().position;
        let Taken {
            begins,
            acknowledges,
            has_goal,
        } = self.control.take(&mut self.server, shaft);
        if acknowledges {
            self.latched = 0;
        }
        if acknowledges || has_goal {
            self.latched &= !status::OVERLOAD;
            self.overload = Timer::default();
        }
        if begins {
            self.begin();
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
}
