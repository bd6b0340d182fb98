//! Firmware update that no loss of power can interrupt for good.
//!
//! ```text
//! bank 1   bootloader 32 KiB │ slot: the image that runs
//! bank 2   parameters │ records │ staging: the image to be installed │ backup: the one before
//! ```
//!
//! The program always runs from the slot. While it runs, a new image is written to the staging
//! area, which is in the other bank. A request to install it is one [`State`] in the append-only
//! [`log`]; after the next reset the bootloader executes it ([`Bootloader::start`]):
//!
//! ```text
//! Idle ─ request ─► Backup ─ slot copied ─► Install ─ staging copied ─► Trial ─ confirmed ─► Idle
//!                                                                        │ not confirmed
//!                                           Idle ◄─ backup copied ─ Restore ◄┘
//! ```
//!
//! Each phase can be repeated from its beginning, and a phase is left only after its result was
//! read back. The library has no heap and no `unsafe`; it runs on the board and, against a model of
//! the flash, in its tests, which cut the supply in every operation.

#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod background;
mod check;
mod flash;
mod header;
mod install;
pub mod layout;
pub mod log;
mod record;
mod signature;
#[cfg(test)]
mod tests;
pub mod waiting;

pub use check::{Policy, Refusal, acceptable, header_of, whole};
pub use flash::{Flash, FlashError, PolledFlash, ReadFlash};
pub use header::{CRC, HEADER_SIZE, Header, SIGNED, Version};
pub use install::{Bootloader, Cause, Decision, MAXIMUM_STARTS};
pub use record::{Bus, Outcome, Phase, State};
pub use signature::{DEVELOPMENT_KEY, DEVELOPMENT_SEED, Key, Verifier, image_hash};

/// The hardware of the actuator board: its product code, object 1018h:2.
pub const ACTUATOR_BOARD: u32 = 0x5341;
