//! The parameters of a model, from the core.

pub use model_core::{
    actuator::{ModelKind, PlantKind, Settings},
    parameter::Value,
    plant::Pwm,
};
