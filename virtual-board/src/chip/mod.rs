//! The microcontroller: the peripherals of rigless and those that this crate adds.

pub(crate) mod bus;
mod mcu;
mod outputs;

pub use mcu::Chip;
