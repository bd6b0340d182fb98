//! The whole actuator as one object: a model, its parameters by name, and a step.
//!
//! [`Settings`] says what it is, [`Actuator`] is stepped by its caller. Neither needs a heap: both
//! can be copied, kept and put back.

pub mod closed_loop;
pub mod kind;
pub mod settings;
pub mod stepped;

pub use kind::{ModelKind, PlantKind};
pub use settings::Settings;
pub use stepped::{Actuator, CommandError, Reading};
