//! The serial-line protocol of LAWICEL's CAN232 and CANUSB adapters, "slcan", that python-can, SavvyCAN and
//! Linux' slcand speak. No I/O: bytes go in, texts come out.
//!
//! | command | does | answer |
//! |---|---|---|
//! | `S0` to `S8` | bit rate 10, 20, 50, 100, 125, 250, 500, 800, 1000 kbit/s; while closed | CR |
//! | `O`, `L` | opens the bus, or only listens | CR |
//! | `C` | closes it | CR |
//! | `tiiildd..`, `Tiiiiiiiildd..` | sends a data frame of 11 or 29 bits | `z` or `Z`, CR |
//! | `riiil`, `Riiiiiiiil` | sends a remote frame | `z` or `Z`, CR |
//! | `F` | status flags, see [`flags`]; those that are latched are cleared; while open | `Fxx` CR |
//! | `V`, `N` | version, serial number | `Vhhss`, `Nssss` CR |
//! | `Z0`, `Z1`, `Z2` | received frames carry no stamp, milliseconds to 59,999 in four digits, microseconds to 3,599,999,999 in eight | CR |
//! | `Mxxxxxxxx`, `mxxxxxxxx` | acceptance code and mask as of an SJA1000 in dual-filter mode; while closed | CR |
//! | none | | CR |
//!
//! Whatever is not possible is answered with BEL (07h). A frame from the bus is a line like those of `t`, `T`, `r` and
//! `R`, with the stamp behind it.
//!
//! [`Adapter`] is what stands between a serial line and a bus, in a microcontroller or a server. A client takes what an
//! adapter says apart with [`parse_frame`], and sends [`Text::frame`].

mod acceptance;
mod adapter;
mod line;

pub use acceptance::Acceptance;
pub use adapter::{Adapter, Bus, Stamps};
pub use line::{Text, parse_frame};

/// Bits of the answer to `F`.
pub mod flags {
    /// Frames from the bus were lost, as the serial line did not take them fast enough.
    pub const RECEIVE_FULL: u8 = 1 << 0;
    /// The queue to the bus was full.
    pub const TRANSMIT_FULL: u8 = 1 << 1;
    /// An error counter is at 96 or above.
    pub const ERROR_WARNING: u8 = 1 << 2;
    /// The CAN controller lost frames.
    pub const OVERRUN: u8 = 1 << 3;
    /// The CAN controller is error passive, or bus-off.
    pub const ERROR_PASSIVE: u8 = 1 << 5;
    /// Arbitration was lost.
    pub const ARBITRATION_LOST: u8 = 1 << 6;
    /// A bus error.
    pub const BUS_ERROR: u8 = 1 << 7;
}

/// Bit rates by the digit of `S`, kbit/s.
pub const KBIT_S: [u16; 9] = [10, 20, 50, 100, 125, 250, 500, 800, 1000];
