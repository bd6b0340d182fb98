//! A CANopen device: communication profile (CiA 301), layer setting services (CiA 305) and the
//! drive profile's state machine and modes (CiA 402).
//!
//! The crate has no heap, no `unsafe`, no I/O and no clock. A [`Node`] receives frames of any
//! [`embedded_can::Frame`] type and the time, and returns the frames to transmit. The user supplies
//! a constant [`Dictionary`] and an [`Application`] that holds the values of all objects outside
//! the communication profile.
//!
//! ```
//! use canopen::dictionary::{Access, Address, DataType, Dictionary, Entry, Mapping};
//! use canopen::{Abort, Application, Node, NodeId};
//!
//! const ENTRIES: &[Entry] = &[
//!     Entry::new(0x1000, 0, DataType::U32, Access::Const).value(0x0002_0192),
//!     Entry::new(0x1017, 0, DataType::U16, Access::ReadWrite).value(100),
//!     Entry::new(0x6064, 0, DataType::I32, Access::Read).mappable(Mapping::Transmit),
//! ];
//! const DICTIONARY: Dictionary = match Dictionary::try_new(ENTRIES, &[], &[]) {
//!     Ok(dictionary) => dictionary,
//!     Err(_) => panic!("invalid object dictionary"),
//! };
//!
//! struct Encoder {
//!     angle_mdeg: i32,
//! }
//!
//! impl Application for Encoder {
//!     fn read(&mut self, entry: &Entry) -> Result<u64, Abort> {
//!         match (entry.address().index, entry.address().sub) {
//!             (0x6064, 0) => Ok(self.angle_mdeg as u64),
//!             _ => Err(Abort::NoObject),
//!         }
//!     }
//!     fn write(&mut self, _: &Entry, _: u64) -> Result<(), Abort> {
//!         Err(Abort::NoObject)
//!     }
//! }
//!
//! let mut encoder = Encoder { angle_mdeg: -45_000 };
//! let mut node = Node::<0, 1>::new(&DICTIONARY, NodeId::new(5), &mut encoder, 0);
//! assert_eq!(node.node_id().map(NodeId::get), Some(5));
//! ```

#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod abort;
mod application;
pub mod cia402;
pub mod cob_id;
pub mod dictionary;
mod emergency;
mod frame;
mod heartbeat;
mod lss;
mod message;
mod nmt;
mod node;
mod objects;
mod pdo;
mod ring;
mod sdo;
mod services;
pub mod slcan;
mod sync;
mod time;
mod timer;

pub use abort::Abort;
pub use application::{Application, BitRate, Event, ParameterGroup, Reset, TimeOfDay};
pub use dictionary::Dictionary;
pub use emergency::{Emergency, ErrorCode, register};
pub use frame::CanFrame;
pub use nmt::{NmtState, NodeId};
pub use node::{BusEvent, Node, SERVICE_IDENTIFIERS};
