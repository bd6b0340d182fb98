//! DroneCAN (UAVCAN v0) for the node of an actuator: transport over classical CAN, dynamic
//! allocation of node-IDs, and the services and messages of the standard that an actuator needs.
//!
//! The crate has no heap, no `unsafe`, no I/O and no clock. A [`Node`] takes frames and times and
//! has frames to send; what commands and parameters do is up to its [`Application`].
//!
//! ```
//! use dronecan::{FrameId, Kind};
//! use embedded_can::ExtendedId;
//!
//! // A command to actuators, of the highest priority, from node 10.
//! let id = ExtendedId::new(0x0003_F20A).unwrap();
//! let command = FrameId { priority: 0, kind: Kind::Message(1010), source: 10 };
//! assert_eq!(FrameId::parse(id), Some(command));
//! ```

#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod allocation;
mod application;
mod assembly;
mod bits;
mod crc;
mod data_types;
mod download;
pub mod float16;
mod id;
mod node;
mod outbox;
mod server;
mod services;

pub use application::{
    Application, Health, Identity, Level, Mode, Opcode, Parameter, Status, Target, Telemetry,
    Value, circuit,
};
pub use assembly::{Assembly, Transfer};
pub use bits::{CAPACITY, Payload, Reader};
pub use crc::crc;
pub use data_types::*;
pub use id::{FrameId, Kind};
pub use node::{Node, Settings};
pub use outbox::{Outbox, Outgoing};
