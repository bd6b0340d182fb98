//! Serial servo buses, device side: the protocol of Feetech's STS, SMS and SCS servos, and
//! Dynamixel 2.0.
//!
//! The crate has no heap, no `unsafe`, no I/O and no clock. A [`Receiver`] finds packets in a
//! stream of bytes; a server ([`feetech::Server`], [`dynamixel::Server`]) applies an instruction to
//! the [`Memory`] of a servo, the bytes behind its control [`Table`], and returns its answer. What
//! the values of the table do is its user's.
//!
//! ```
//! use servo_bus::{Receiver, feetech, tables::{STS3215, sts}};
//!
//! let mut servo = feetech::Server::new(&STS3215, 1);
//! let mut receiver = Receiver::<feetech::Framing>::default();
//! // The position 2048 and the speed 1000, as in the manual's fourth example.
//! for byte in [0xFF, 0xFF, 1, 9, 3, 0x2A, 0, 8, 0, 0, 0xE8, 3, 0xD5] {
//!     receiver.push(byte);
//! }
//! let answer = receiver.next_packet().and_then(|packet| servo.receive(packet)).unwrap();
//! assert_eq!(*answer.bytes, [0xFF, 0xFF, 1, 2, 0, 0xFC]);
//! assert_eq!(servo.memory.get(sts::GOAL_POSITION), 2048);
//! ```

#![no_std]

#[cfg(test)]
extern crate std;

mod answer;
mod bytes;
pub mod dynamixel;
pub mod feetech;
mod memory;
mod receiver;
mod table;

/// Control tables, and the registers of each family.
pub mod tables {
    use super::table::{Field, Order, Register, Registers, Sign, Table};

    include!(concat!(env!("OUT_DIR"), "/tables.rs"));
}

pub use answer::Answer;
pub use bytes::{Bytes, CAPACITY};
pub use memory::{EEPROM, Memory, Refusal};
pub use receiver::{Framing, Receiver, Scan};
pub use table::{Field, Order, Register, RegisterIter, Registers, Sign, Table};

/// Steps of the encoder per turn.
pub const TURN: i32 = 4096;

/// Position in the middle of a turn, in steps.
pub const MIDDLE: i32 = TURN / 2;

/// Greatest velocity and acceleration of the trajectory to a goal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Profile {
    /// Steps/s.
    pub velocity: u32,
    /// Steps/s^2; the greatest value without a limit.
    pub acceleration: u32,
}

/// The ID of all servos.
pub const BROADCAST: u8 = 0xFE;
