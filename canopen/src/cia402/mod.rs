//! Drive profile CiA 402, independent of any bus: controlword in, statusword out.
//!
//! [`Axis::step`] runs once in each control period. It runs the state machine, generates the demand
//! of the modes profile position, velocity and torque, homing, interpolated position, and cyclic
//! synchronous position, velocity and torque, and monitors following error and target windows. All
//! values are integers in any position unit; velocities are in that unit per second, accelerations
//! in that unit per second squared, torques in thousandths of the rated torque.

mod axis;
mod homing;
mod modes;
mod options;
mod parameters;
mod ramp;
mod set_point;
mod smooth;
mod state;
mod window;
mod words;

pub use axis::{Axis, Demand, Input, Offsets, Output};
pub use homing::{Direction, HomingMethod, HomingParameters};
pub use modes::Mode;
pub use options::{Deceleration, QuickStop, StopOption};
pub use parameters::{Parameters, RelativeTo};
pub use ramp::{Limits, Ramp};
pub use state::{Cia402State, Conditions, Fault, Motion, Options, StateMachine};
pub use words::{Command, controlword, statusword};
