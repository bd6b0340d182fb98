//! The microcontrollers: the peripherals of rigless and those that this crate adds.

mod actuator;
pub(crate) mod bus;
mod crc_unit;
mod h743;
mod mcu;
mod outputs;
mod window_watchdog;

pub use actuator::ActuatorChip;
pub use crc_unit::Remainder;
pub use h743::ChipH743;
pub use mcu::Chip;
pub(crate) use mcu::{USART1, USART3};
pub use outputs::PwmTimer;
