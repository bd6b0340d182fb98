//! The microcontroller: the peripherals of rigless and those that this crate adds.

pub(crate) mod bus;
mod crc_unit;
mod mcu;
mod outputs;
mod window_watchdog;

pub use mcu::Chip;
