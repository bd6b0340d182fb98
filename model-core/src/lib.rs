//! Control core, actuator models and excitations of a smart RC-servo actuator.
//!
//! The crate has no dependency on a bus, hardware, a clock or a heap: functions take structs and
//! return structs. Computations of the board are in fixed point ([`control`], [`excitation`]);
//! models of the physical world and the evaluation of runs are in `f64` ([`models`], [`plant`],
//! [`sensors`], [`evaluation`]).
//!
//! ```
//! use model_core::actuator::{Actuator, ModelKind, PlantKind, Settings};
//!
//! // The board's loops around a motor, for a second in ticks of 50 us.
//! let mut settings = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
//! settings.set("position_gain", 9.0)?;
//! let mut servo = Actuator::try_new(&settings)?;
//! servo.advance(30.0, 20_000).expect("a finite command");
//! // Within an encoder count.
//! assert!((servo.reading().angle_deg - 30.0).abs() < 360.0 / 4096.0);
//! # Ok::<(), model_core::parameter::ParameterError>(())
//! ```

#![no_std]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod actuator;
pub mod control;
pub mod evaluation;
pub mod excitation;
mod limits;
pub mod models;
pub mod named;
pub mod parameter;
pub mod plant;
pub mod presets;
pub mod scenario;
pub mod sensors;
pub mod time;
