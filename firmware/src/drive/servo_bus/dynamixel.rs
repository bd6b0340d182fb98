//! The control table of a Dynamixel of the X series, with the loop of the board: gains, the goal
//! PWM and the startup configuration have no effect, and there is no PWM mode.

use canopen::cia402::Limits;
use servo_bus::dynamixel::{Control, FULL_PWM, Framing, Measured, Server, Taken, error, mode};
use servo_bus::{Answer, Memory, tables::x};

use super::motor::{
    Demand, MostTorque, Sensed, Target, bit_rate, current_units, in_ma, in_mdeg, limits, mdeg,
    steps, steps_s,
};
use super::trajectory::Trajectory;
use super::{PERIOD_US, Servo};

/// Bit rates by their number in the table, bit/s.
const BIT_RATES: [u32; 8] = [
    9_600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000,
];

/// The servo.
#[derive(Debug)]
pub(super) struct Dynamixel {
    server: Server,
    /// `None` until the angle is known.
    control: Option<Control>,
    taken: Taken,
    /// Position of the shaft at the last exchange, steps.
    shaft: i32,
    trajectory: Trajectory,
    /// Limits of the trajectory, mdeg.
    limits: Limits,
}

/// Of a trajectory without a profile.
const UNLIMITED: Limits = Limits {
    velocity: u32::MAX,
    acceleration: u32::MAX,
    deceleration: u32::MAX,
};

impl Dynamixel {
    /// After a start, with these registers.
    pub fn new(memory: Memory) -> Self {
        Self {
            server: Server::with(memory),
            control: None,
            taken: Taken::default(),
            shaft: 0,
            trajectory: Trajectory::at(0),
            limits: UNLIMITED,
        }
    }

    /// The angle is known. What was written before moves nothing.
    fn start(&mut self, shaft: i32) -> Control {
        let mut control = Control::new(&mut self.server.memory, shaft);
        control.take(&mut self.server, shaft);
        control.turn_off(&mut self.server.memory);
        control
    }

    /// The trajectory to a goal begins.
    fn begin(&mut self, control: &Control, taken: &Taken, sensed: &Sensed) {
        if taken.begins {
            self.trajectory.begin(sensed);
        }
        let memory = &self.server.memory;
        let goal = memory.get(x::GOAL_POSITION);
        let travel = goal.wrapping_sub(control.position(memory, self.shaft));
        let forward = Control::direction(memory);
        self.trajectory.goal = mdeg(self.shaft.wrapping_add(forward.wrapping_mul(travel)));
        let distance = steps(self.trajectory.goal).abs_diff(steps(self.trajectory.position()));
        let velocity = steps_s(self.trajectory.velocity());
        let profile = control.profile(memory, distance, velocity);
        self.limits = profile.map_or(UNLIMITED, limits);
    }

    /// The next demand of a control that is on.
    fn target(&mut self, control: &Control, sensed: &Sensed, periods: u32) -> Target {
        let memory = &self.server.memory;
        let (forward, limits) = (Control::direction(memory), self.limits);
        match control.mode {
            mode::CURRENT => {
                let current = in_ma(memory.table(), memory.get(x::GOAL_CURRENT));
                Target::Current(forward * current)
            }
            mode::VELOCITY => {
                let goal = forward * in_mdeg(Control::goal_velocity(memory).into());
                self.trajectory.continue_at(goal, &limits, periods)
            }
            mode::PWM => Target::Off,
            _ => self.trajectory.continue_to_goal(&limits, sensed, periods),
        }
    }

    /// Position and velocity of the trajectory, in units of the table.
    fn reported_trajectory(&self, control: &Control) -> (i32, i32) {
        let memory = &self.server.memory;
        let position = control.position(memory, steps(self.trajectory.position()));
        let velocity = Control::velocity_units(steps_s(self.trajectory.velocity()));
        (position, Control::direction(memory) * velocity)
    }
}

impl Servo for Dynamixel {
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
        bit_rate(&self.server.memory, x::BAUD_RATE, &BIT_RATES).unwrap_or(57_600)
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
        let ms = (periods * PERIOD_US / 1000) as i32;
        if control.elapse(memory, ms, shaft) {
            (taken.begins, taken.has_goal) = (true, true);
        }
        let is_turned_on = taken.has_torque && control.is_driven;
        let is_stopped = sensed.is_stopped && !is_turned_on;
        let has_power = sensed.is_driven || taken.begins;
        if !has_power || is_stopped || taken.restarts || control.mode == mode::PWM {
            control.turn_off(memory);
        }
        if taken.begins || taken.has_goal {
            self.begin(&control, &taken, sensed);
        }
        let target = match control.is_driven {
            true => self.target(&control, sensed, periods),
            false => Target::Off,
        };
        let trajectory = self.reported_trajectory(&control);
        let memory = &mut self.server.memory;
        let most = match control.mode {
            mode::CURRENT_BASED_POSITION => memory.get(x::GOAL_CURRENT),
            _ => memory.get(x::CURRENT_LIMIT),
        };
        let faults = sensed.bits([
            error::VOLTAGE,
            error::ENCODER,
            error::TEMPERATURE,
            error::SHOCK,
            error::OVERLOAD,
            error::SHOCK,
        ]);
        // The restart has yet to acknowledge them.
        let is_acknowledging = taken.restarts || sensed.is_waiting;
        let errors = if is_acknowledging { 0 } else { faults };
        let measured = Measured {
            shaft,
            rate: Control::velocity_units(steps_s(sensed.rate_mdeg_s)),
            pwm: sensed.duty_permille * FULL_PWM / 1000,
            current: current_units(memory.table(), sensed.current_ma),
            voltage: sensed.voltage,
            temperature: sensed.temperature,
            trajectory,
            errors,
        };
        control.report(memory, &measured);
        self.control = Some(control);
        Demand {
            target,
            most_torque: MostTorque::OfCurrent(in_ma(self.server.memory.table(), most)),
            acknowledges: taken.restarts,
            ends_stop: is_turned_on,
        }
    }
}
