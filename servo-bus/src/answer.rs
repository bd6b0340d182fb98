//! The answer of a servo.

use crate::bytes::Bytes;

/// A status packet, or the part of one that several servos send together.
#[derive(Debug, Clone)]
pub struct Answer {
    /// Its place among the answers of all servos to the same instruction.
    pub turn: u8,
    /// Pause before it, us.
    pub delay_us: u16,
    /// Bytes of the servos before it that it continues.
    pub bytes_before: u16,
    /// Its bytes.
    pub bytes: Bytes,
    /// Whether it continues the packet of the servos before it: [`crate::dynamixel::link`].
    pub is_linked: bool,
}
