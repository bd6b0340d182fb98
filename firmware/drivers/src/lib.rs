//! Drivers of the actuator board, for any chip.
//!
//! A driver has the logic of a part of the board and leaves the registers to a small trait, that of
//! embedded-hal where it fits. `firmware/boards/` implements the traits for each chip; the tests
//! implement them by mocks.
//!
//! - [`encoder`]: the AS5045, over a transfer that interrupts at its end, with
//!   `embedded_hal::digital::OutputPin` as chip select
//! - [`bridge`]: the H-bridge with its trip, over [`bridge::PwmTimer`], as
//!   `embedded_hal::pwm::SetDutyCycle` has neither a trip nor an output that is off
//! - [`can`]: the CAN controller and its queues, over [`can::CanPort`]
//!
//! The flash of the parameters is behind [`firmware::store::Flash`], which each chip implements.
//! Nothing in this crate allocates, blocks or panics, for any input.
#![no_std]
#![forbid(unsafe_code)]

pub mod bridge;
pub mod can;
pub mod encoder;
