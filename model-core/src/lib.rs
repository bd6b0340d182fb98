//! Control core, actuator models and excitations of a smart RC-servo actuator.
//!
//! The crate knows no bus, no hardware, no clock and no heap: structs go in, structs come out. What
//! the board computes is fixed point ([`control`], [`excitation`]); what stands for the physical
//! world is `f64` ([`models`], [`plant`], [`sensors`]).

#![no_std]

#[cfg(test)]
extern crate std;

pub mod actuator;
pub mod control;
pub mod excitation;
mod limits;
pub mod models;
pub mod named;
pub mod parameter;
pub mod plant;
pub mod presets;
pub mod sensors;
pub mod time;
