//! Identifiers of the predefined connection set (CiA 301, 7.3.5) and of LSS (CiA 305).
//!
//! A function's own bits with the node-ID below them.

use embedded_can::StandardId;

/// Commands of the NMT master; node 0.
pub const NMT: u32 = 0;
/// Emergencies; of node 0, SYNC.
pub const EMERGENCY: u32 = 0x80;
/// The time; node 0.
pub const TIME: u32 = 0x100;
/// Responses of an SDO server.
pub const SDO_RESPONSE: u32 = 0x580;
/// Requests to an SDO server.
pub const SDO_REQUEST: u32 = 0x600;
/// Heartbeats and boot-up messages.
pub const HEARTBEAT: u32 = 0x700;
/// Responses of LSS slaves, without a node-ID.
pub const LSS_RESPONSE: u32 = 0x7E4;
/// Requests of the LSS master, without a node-ID.
pub const LSS_REQUEST: u32 = 0x7E5;

/// A transmit PDO by its number, 1 to 4.
pub const fn tpdo(number: u32) -> u32 {
    0x80 + 0x100 * number
}

/// A receive PDO by its number, 1 to 4.
pub const fn rpdo(number: u32) -> u32 {
    0x100 + 0x100 * number
}

/// The function and the node-ID of an identifier.
///
/// ```
/// use canopen::cob_id::{SDO_REQUEST, split};
/// assert_eq!(split(0x605), (SDO_REQUEST, 5));
/// ```
pub const fn split(id: u32) -> (u32, u8) {
    (id & 0x780, (id & 0x7F) as u8)
}

/// The identifier of a function of a node, 1 to 127, for a frame.
///
/// ```
/// use canopen::cob_id::{HEARTBEAT, of_node};
/// assert_eq!(of_node(HEARTBEAT, 1).as_raw(), 0x701);
/// ```
pub fn of_node(function: u32, node: u8) -> StandardId {
    StandardId::new(function as u16 | u16::from(node & 0x7F)).unwrap_or(StandardId::MAX)
}
