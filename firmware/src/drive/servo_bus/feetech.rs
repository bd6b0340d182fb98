//! The control table of an STS servo, with the loop of the board: gains, dead zones and the
//! starting force have no effect, nor has the mode of the duty, and a braked torque is off.

use servo_bus::feetech::{Control, Framing, Measured, Server, Taken, mode, status};
use servo_bus::{Answer, Memory, tables::sts};

use super::Servo;
use super::motor::{
    Demand, MostTorque, Sensed, Target, bit_rate, current_units, in_mdeg, limits, mdeg, steps,
    steps_s,
};
use super::trajectory::Trajectory;

/// Bit rates by their number in the table, bit/s.
const BIT_RATES: [u32; 8] = [
    1_000_000, 500_000, 250_000, 128_000, 115_200, 76_800, 57_600, 38_400,
];

/// The servo.
#[derive(Debug)]
pub(super) struct Feetech {
    server: Server,
    /// `None` until the angle is known.
    control: Option<Control>,
    taken: Taken,
    /// Position of the shaft at the last exchange, steps.
    shaft: i32,
    trajectory: Trajectory,
}

impl Feetech {
    /// After a start, with these registers.
    pub fn new(memory: Memory) -> Self {
        Self {
            server: Server::with(memory),
            control: None,
            taken: Taken::default(),
            shaft: 0,
            trajectory: Trajectory::at(0),
        }
    }

    /// The angle is known. What was written before moves nothing.
    fn start(&mut self, shaft: i32) -> Control {
        let mut control = Control::new(&mut self.server.memory, shaft);
        control.take(&mut self.server, shaft);
        control.turn_off(&mut self.server.memory);
        control
    }

    /// The next demand of a control that is on.
    fn target(&mut self, control: &Control, sensed: &Sensed, periods: u32) -> Target {
        let memory = &self.server.memory;
        let limits = limits(Control::profile(memory));
        match control.mode {
            mode::WHEEL => {
                let goal = in_mdeg(Control::speed(memory).into());
                self.trajectory.continue_at(goal, &limits, periods)
            }
            mode::PWM => Target::Off,
            _ => self.trajectory.continue_to_goal(&limits, sensed, periods),
        }
    }
}

impl Servo for Feetech {
    type Framing = Framing;

    fn receive(&mut self, packet: &[u8]) -> Option<Answer> {
        let answer = self.server.receive(packet);
        if let Some(control) = &mut self.control {
            self.taken.add(control.take(&mut self.server, self.shaft));
        }
        answer
    }

    fn memory(&self) -> &Memory {
        &self.server.memory
    }

    fn bit_rate(&self) -> u32 {
        bit_rate(&self.server.memory, sts::BAUD_RATE, &BIT_RATES).unwrap_or(1_000_000)
    }

    fn exchange(&mut self, sensed: &Sensed, periods: u32) -> Demand {
        self.shaft = steps(sensed.position_mdeg);
        let shaft = self.shaft;
        let mut control = match self.control {
            Some(control) => control,
            None => self.start(shaft),
        };
        let mut taken = core::mem::take(&mut self.taken);
        let memory = &mut self.server.memory;
        let is_turned_on = taken.acknowledges && control.torque == 1;
        let is_stopped = sensed.is_stopped && !is_turned_on;
        let has_power = sensed.is_driven || taken.begins || taken.has_goal;
        if !has_power || is_stopped || control.mode == mode::PWM {
            control.turn_off(memory);
        }
        // The loop is closed anew, where the shaft is.
        taken.begins |= taken.has_goal && !sensed.is_driven;
        if taken.begins {
            self.trajectory.begin(sensed);
            if !taken.has_goal {
                // Turning the torque on moves nothing.
                control.hold(memory, shaft);
            }
        }
        if taken.begins || taken.has_goal {
            let travel = control.goal.wrapping_sub(control.position(memory, shaft));
            self.trajectory.goal = mdeg(shaft.wrapping_add(travel));
        }
        let most = memory.get(sts::TORQUE_LIMIT) as u16;
        let target = match control.torque {
            1 => self.target(&control, sensed, periods),
            _ => Target::Off,
        };
        let faults = sensed.bits([
            status::VOLTAGE,
            status::ENCODER,
            status::TEMPERATURE,
            status::CURRENT,
            status::OVERLOAD,
            status::ENCODER,
        ]);
        let measured = Measured {
            shaft,
            rate: steps_s(sensed.rate_mdeg_s),
            load_permille: sensed.duty_permille,
            voltage: sensed.voltage,
            temperature: sensed.temperature,
            current: current_units(self.server.memory.table(), sensed.current_ma),
            status: faults,
            is_under_way: self.trajectory.position() != self.trajectory.goal,
        };
        control.report(&mut self.server.memory, &measured);
        self.control = Some(control);
        Demand {
            target,
            most_torque: MostTorque::Share(most),
            acknowledges: taken.acknowledges || taken.has_goal && sensed.has_load_faults_only(),
            ends_stop: is_turned_on,
        }
    }
}
