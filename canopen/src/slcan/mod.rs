//! The serial-line protocol "slcan" of LAWICEL's CAN232 and CANUSB adapters, which python-can,
//! SavvyCAN and Linux' slcand support. No I/O: bytes in, lines out.
//!
//! | command | function | answer |
//! |---|---|---|
//! | `S0` to `S8` | bit rate 10, 20, 50, 100, 125, 250, 500, 800, 1000 kbit/s; while closed | CR |
//! | `O`, `L` | opens the bus in normal or listen-only mode | CR |
//! | `C` | closes the bus | CR |
//! | `tiiildd..`, `Tiiiiiiiildd..` | sends a data frame of 11 or 29 bits | `z` or `Z`, CR |
//! | `riiil`, `Riiiiiiiil` | sends a remote frame | `z` or `Z`, CR |
//! | `F` | status flags, see [`flags`]; reading clears the latched flags; while open | `Fxx` CR |
//! | `V`, `N` | version, serial number | `Vhhss`, `Nssss` CR |
//! | `Z0`, `Z1`, `Z2` | received frames carry no timestamp, milliseconds to 59,999 in four digits, microseconds to 3,599,999,999 in eight | CR |
//! | `Mxxxxxxxx`, `mxxxxxxxx` | acceptance code and mask of an SJA1000 in dual-filter mode; while closed | CR |
//! | empty line | | CR |
//!
//! An invalid command is answered with BEL (07h). A received frame is a line like those of `t`,
//! `T`, `r` and `R`, followed by the timestamp.
//!
//! [`Adapter`] implements the adapter, in a microcontroller or a server. A client parses received
//! lines with [`parse_frame`] and sends [`SlcanLine::frame`].

mod acceptance;
mod adapter;
mod line;

pub use acceptance::Acceptance;
pub use adapter::{Adapter, Bus, Timestamps};
pub use line::{SlcanLine, parse_frame};

/// Bits of the answer to `F`.
pub mod flags {
    /// Received frames were lost because the serial line was full.
    pub const RECEIVE_FULL: u8 = 1 << 0;
    /// The transmit queue was full.
    pub const TRANSMIT_FULL: u8 = 1 << 1;
    /// An error counter is at 96 or above.
    pub const ERROR_WARNING: u8 = 1 << 2;
    /// The CAN controller lost frames.
    pub const OVERRUN: u8 = 1 << 3;
    /// The CAN controller is error passive, or bus-off.
    pub const ERROR_PASSIVE: u8 = 1 << 5;
    /// Arbitration was lost.
    pub const ARBITRATION_LOST: u8 = 1 << 6;
    /// A bus error occurred.
    pub const BUS_ERROR: u8 = 1 << 7;
}

/// Bit rates by the digit of `S`, kbit/s.
pub const KBIT_S: [u16; 9] = [10, 20, 50, 100, 125, 250, 500, 800, 1000];
