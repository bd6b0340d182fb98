//! Tests of the drive profile against CiA 402: states, stop options, modes and windows.

mod homing;
mod limits;
mod model;
mod modes;
mod profiles;
mod random;
mod states;
mod stops;
mod tables;
mod torque;

use canopen::cia402::{Axis, Demand, Input, Mode, Output, Parameters, StateMachine, controlword};

const ENABLE: u16 = 0x000F;

/// An axis of a control period in microseconds, with a motor that follows the demand with a delay
/// of one period.
struct BenchOf<const PERIOD_US: u32> {
    axis: Axis<PERIOD_US>,
    input: Input,
    parameters: Parameters,
    follows: bool,
}

/// Of a control period of 4 ms.
type Bench = BenchOf<4000>;

impl<const PERIOD_US: u32> BenchOf<PERIOD_US> {
    fn new(mode: Mode) -> Self {
        // A master that writes its targets in each period.
        let input = Input {
            mode,
            is_new_position: true,
            is_new_velocity: true,
            is_new_torque: true,
            ..Input::default()
        };
        Self {
            axis: Axis::new(),
            input,
            parameters: parameters(),
            follows: true,
        }
    }

    /// An axis in "operation enabled".
    fn enabled(mode: Mode) -> Self {
        let mut bench = Self::new(mode);
        for word in [0, 0x06, 0x07, ENABLE] {
            bench.command(word);
        }
        assert_eq!(
            bench.axis.state(),
            canopen::cia402::Cia402State::OperationEnabled
        );
        bench
    }

    /// Whether the master writes its targets in each period from now on.
    fn writes(&mut self, writes: bool) {
        self.input.is_new_position = writes;
        self.input.is_new_velocity = writes;
        self.input.is_new_torque = writes;
    }

    fn step(&mut self) -> Output {
        let output = self.axis.step(self.input, &self.parameters);
        if self.follows {
            match output.demand {
                Demand::Off => self.input.velocity_actual = 0,
                Demand::Position { position, velocity } => {
                    self.input.position_actual = position;
                    self.input.velocity_actual = velocity;
                }
                Demand::Velocity(velocity) => self.turn(velocity),
                Demand::Torque { torque, velocities } => {
                    // The rated torque accelerates with 1000 deg/s^2.
                    let faster = self.input.velocity_actual + 4 * i32::from(torque);
                    self.turn(faster.clamp(velocities.0, velocities.1));
                }
            }
        }
        output
    }

    fn turn(&mut self, velocity: i32) {
        self.input.velocity_actual = velocity;
        let way = i64::from(velocity) * i64::from(PERIOD_US) / 1_000_000;
        self.input.position_actual += way as i32;
    }

    fn command(&mut self, word: u16) -> Output {
        self.input.controlword = word;
        self.step()
    }

    fn run(&mut self, periods: usize) {
        for _ in 0..periods {
            self.step();
        }
    }

    /// Steps until the condition holds; returns the number of periods.
    fn until(&mut self, holds: impl Fn(&Output) -> bool) -> usize {
        (1..10_000)
            .find(|_| holds(&self.step()))
            .expect("the condition never holds")
    }
}

fn parameters() -> Parameters {
    Parameters {
        velocity_window: 1_000,
        velocity_threshold: 500,
        velocity_threshold_time_ms: 0,
        ..Parameters::default()
    }
}

const NEW: u16 = ENABLE | controlword::NEW_SET_POINT;

/// A state machine after power-on.
fn machine() -> StateMachine {
    StateMachine::new()
}
