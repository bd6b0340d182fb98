//! Dynamixel protocol 2.0, after <https://emanual.robotis.com/docs/en/dxl/protocol2/> and the pages
//! of the X series.
//!
//! ```text
//! FF FF FD 00  ID  length (2)  instruction  parameters  CRC (2)
//! ```
//!
//! The length counts what follows it. Behind FF FF FD, instruction and parameters have another FD,
//! so that no header is in them; length and CRC count it.

mod control;
mod crc;
mod instruction;
mod packet;
mod rules;
mod server;

pub use control::{Control, FULL_PWM, Measured, Taken, error, mode};
pub use crc::crc;
pub use instruction::{Instruction, Item};
pub use packet::{Framing, Packet, encode, link};
pub use rules::Error;
pub use server::{Event, Server};
