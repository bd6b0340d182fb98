//! Feetech's protocol for STS, SMS and SCS servos, after *Servo SCS Communication Protocol* and the
//! memory tables of doc.feetech.cn.
//!
//! ```text
//! FF FF  ID  length  instruction or status  parameters  check
//! ```
//!
//! The length counts what follows it; the check value is the inverted sum of all from the ID on.

mod control;
mod instruction;
mod packet;
mod server;

pub use control::{ACCELERATION_UNIT, Control, Measured, SPEED_UNIT, Taken, mode, status};
pub use instruction::Instruction;
pub use packet::{Framing, Packet, encode};
pub use server::{Event, Server};
