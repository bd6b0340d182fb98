//! The logic of the drive profile CiA 402, free of any bus: controlword in, statusword out.
//!
//! [`Axis::step`] runs once in each control period. It walks through the states, generates the demand of the modes
//! profile position, profile velocity, cyclic synchronous position and cyclic synchronous velocity, and watches
//! following error and target windows. All in integers, in any position unit: the unit of velocity is that per second,
//! of acceleration that per second squared.

mod axis;
mod modes;
mod options;
mod parameters;
mod ramp;
mod set_point;
mod state;
mod window;
mod words;

pub use axis::{Axis, Demand, Input, Output};
pub use modes::Mode;
pub use options::{Deceleration, QuickStop, StopOption};
pub use parameters::Parameters;
pub use ramp::{Limits, Ramp};
pub use state::{Conditions, Fault, Motion, Options, State, StateMachine};
pub use words::{Command, controlword, statusword};
