//! The complete actuator as one object: a model, its parameters by name, and a step.
//!
//! [`Settings`] contains model and parameters, [`Actuator`] is stepped by its caller. Neither uses
//! the heap: both can be copied, stored and restored.

mod board;
pub mod closed_loop;
mod input;
pub mod kind;
pub mod lanes;
mod load;
mod reading;
mod retune;
pub mod settings;
mod state;
pub mod stepped;
mod stepped_core;

pub use input::{COMMAND_RANGE, CommandError, InputLevel, LOAD_TORQUE_RANGE_NM};
pub use kind::{ModelKind, PlantKind};
pub use reading::Reading;
pub use settings::Settings;
pub use state::{CoreState, OtherModel};
pub use stepped::Actuator;
pub use stepped_core::{ActuatorCore, demand};

#[cfg(test)]
mod tests;
