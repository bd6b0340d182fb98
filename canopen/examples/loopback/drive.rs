//! Example drive with an ideal motor, connected to the objects of the example.

use canopen::Node;
use canopen::cia402::{Axis, Cia402State, Demand, Fault, Input, Mode, Parameters};
use canopen::dictionary::Address;

use crate::device::Device;

const PERIOD_US: u32 = 4_000;

/// The axis and the time of its next step.
#[derive(Default)]
pub struct Drive {
    axis: Axis<PERIOD_US>,
    next_us: u64,
    position: i32,
    velocity: i32,
}

impl Drive {
    /// Performs all steps that are due, and reports changes of the statusword to the node.
    pub fn run(&mut self, now_us: u64, device: &mut Device, node: &mut Node<2, 2>) {
        while self.next_us <= now_us {
            self.next_us += u64::from(PERIOD_US);
            let before = device.number(0x6041, 0);
            self.step(device);
            if device.number(0x6041, 0) != before {
                node.object_changed(Address::new(0x6041, 0));
            }
        }
    }

    fn step(&mut self, device: &mut Device) {
        let mode = Mode::from_code(device.number(0x6060, 0) as i8).unwrap_or(Mode::None);
        let input = Input {
            controlword: device.number(0x6040, 0) as u16,
            mode,
            target_position: device.number(0x607A, 0) as i32,
            target_velocity: device.number(0x60FF, 0) as i32,
            is_new_position: core::mem::take(&mut device.is_new_position),
            is_new_velocity: core::mem::take(&mut device.is_new_velocity),
            position_actual: self.position,
            velocity_actual: self.velocity,
            fault: if device.number(0x2007, 0) == 0 {
                Fault::None
            } else {
                Fault::Controlled
            },
            ..Input::default()
        };
        let limits = (
            device.number(0x607D, 1) as i32,
            device.number(0x607D, 2) as i32,
        );
        let output = self.axis.step(input, &parameters(limits));
        self.velocity = 0;
        match output.demand {
            // No object of this device has a target torque.
            Demand::Off | Demand::Torque { .. } => {}
            Demand::Position { position, velocity } => {
                (self.position, self.velocity) = (position, velocity);
            }
            Demand::Velocity(velocity) => {
                self.velocity = velocity;
                self.position += (i64::from(velocity) * i64::from(PERIOD_US) / 1_000_000) as i32;
            }
        }
        device.enabled = output.state == Cia402State::OperationEnabled;
        device.set(0x6041, i64::from(output.statusword));
        device.set(0x6061, i64::from(mode as i8));
        device.set(0x6064, i64::from(self.position));
    }
}

fn parameters(position_limits: (i32, i32)) -> Parameters {
    Parameters {
        position_limits: Some(position_limits),
        ..Parameters::default()
    }
}
