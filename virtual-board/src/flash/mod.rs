//! The flash memory of the STM32F427 (RM0090, chapter 3): registers of the interface, and the array
//! with its timing, its errors and its contents after a power loss during an operation.
//!
//! ```text
//! firmware ── KEYR, CR, SR ── Interface ── Operation ── array
//!          ── stores to 0x0800_0000..  ──┘
//! ```
//!
//! Not modelled: programming with an external VPP, read-out protection, and the stall of a read
//! from the bank that is being changed: such a read returns the present content of the sector. An
//! operation on bank 1, from which the firmware runs, stalls the core ([`Interface::stalls_core`]).

mod interface;
mod operation;
mod power_loss;
mod sectors;
#[cfg(test)]
mod tests;
mod times;

pub use interface::Interface;
pub use operation::{Operation, Started};
pub use sectors::{BANK_2, BASE, SIZE, Sector};
pub use times::{EraseTimes, FlashTimes};
