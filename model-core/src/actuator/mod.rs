//! The complete actuator as one object: a model, its parameters by name, and a step.
//!
//! [`Settings`] contains model and parameters, [`Actuator`] is stepped by its caller. Neither uses
//! the heap: both can be copied, stored and restored.

pub mod closed_loop;
pub mod kind;
pub mod lanes;
pub mod settings;
pub mod stepped;

pub use kind::{ModelKind, PlantKind};
pub use settings::Settings;
pub use stepped::{Actuator, CommandError, Reading};
