//! Control core, actuator models and excitations of a smart RC-servo actuator.
//!
//! The crate has no dependency on a bus, hardware, a clock or a heap: functions take structs and
//! return structs. Computations of the board are in fixed point ([`control`], [`excitation`]);
//! models of the physical world and the evaluation of runs are in `f64` ([`models`], [`plant`],
//! [`sensors`], [`evaluation`]).

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
