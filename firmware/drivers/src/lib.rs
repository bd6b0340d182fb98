//! Drivers of the actuator board, for any chip.
//!
//! A driver has the logic of a part of the board and leaves the registers to a small trait, that of
//! embedded-hal where it fits. `firmware/boards/` implements the traits for each chip; the tests
//! implement them by mocks.
//!
//! - [`encoder`]: the AS5045, over `embedded_hal::spi::SpiDevice`, or over a transfer that
//!   interrupts at its end, with `embedded_hal::digital::OutputPin` as chip select
//! - [`bridge`]: the H-bridge with its trip, over [`bridge::PwmTimer`], as
//!   `embedded_hal::pwm::SetDutyCycle` has neither a trip nor an output that is off
//! - [`can`]: the CAN controller and its queues, over [`can::CanPort`], which [`can::NbCan`] makes
//!   an `embedded_can::nb::Can`
//! - [`store`]: the flash of the parameters, over `embedded_storage::nor_flash::NorFlash`, or over
//!   [`firmware::store::Flash`], which does not block
//! - [`checks`]: tests of these drivers, for a PC and for each chip
//!
//! Nothing in this crate allocates or panics, for any input; a blocking driver says so.
#![no_std]
#![forbid(unsafe_code)]

pub mod bridge;
pub mod can;
pub mod checks;
pub mod encoder;
pub mod store;
