//! The flash memory of the STM32F427 (RM0090, chapter 3): the interface's registers, and the array
//! behind them with its times, its errors and what a power loss leaves of an operation.
//!
//! ```text
//! firmware ── KEYR, CR, SR ── Interface ── Operation ── array
//!          ── stores to 0x0800_0000..  ──┘
//! ```
//!
//! Left out: programming with an external VPP, protection against readout, and the stall of a read
//! from the bank that is being changed: such a read gives what the sector holds meanwhile, which is
//! of no use to anybody. An operation on bank 1, from which the firmware runs, holds the core
//! ([`Interface::holds_core`]).

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
