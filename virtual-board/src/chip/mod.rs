//! The microcontroller: the parts of rigless, with what they lack.

pub(crate) mod bus;
mod mcu;
mod outputs;

pub use mcu::Chip;
