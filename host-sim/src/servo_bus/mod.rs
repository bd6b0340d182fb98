//! Simulated servos on a serial bus: the protocols and control tables of `servo_bus` around models
//! of the motors.
//!
//! Each [`Servo`] computes periods of 1 ms: what its table commands becomes a duty of its bridge,
//! the motor and its gears are simulated, and what they do is written to the table. Time is that of
//! the caller.

mod bus;
pub mod client;
mod dynamixel;
mod fault;
mod feetech;
mod model;
mod motor;
mod server;
#[cfg(test)]
mod tests;

pub use bus::{Bus, Servo};
pub use fault::{Fault, NoFault, OfServo};
pub use model::{Model, NAMES, model};
pub use server::Server;

/// Length of a period, us.
const PERIOD_US: u32 = 1000;
