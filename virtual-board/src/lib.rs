//! The emulated actuator board: an STM32F427 that runs the release ELF in lockstep with a motor
//! model.

pub mod can;
pub mod chip;
pub mod flash;
pub mod rig;
