//! Instructions in plain form.

use super::Packet;

/// What an instruction packet asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instruction<'a> {
    /// An answer.
    Ping,
    /// The bytes from an address on.
    Read {
        /// First address.
        address: u8,
        /// Number of bytes.
        length: u8,
    },
    /// Bytes to an address.
    Write {
        /// First address.
        address: u8,
        /// The bytes.
        data: &'a [u8],
    },
    /// The same at the next action.
    RegWrite {
        /// First address.
        address: u8,
        /// The bytes.
        data: &'a [u8],
    },
    /// The registered write.
    Action,
    /// The values of the backup but the ID.
    Recover,
    /// A start.
    Restart,
    /// Present values as the backup.
    BackUp,
    /// The position within a turn.
    ResetTurns,
    /// The present position as this one; without it, as the middle.
    Calibrate(Option<[u8; 2]>),
    /// The same bytes of several servos.
    SyncRead {
        /// First address.
        address: u8,
        /// Number of bytes.
        length: u8,
        /// The servos.
        ids: &'a [u8],
    },
    /// Bytes to the same address of several servos.
    SyncWrite {
        /// First address.
        address: u8,
        /// Number of bytes of each.
        length: u8,
        /// For each servo its ID and its bytes.
        items: &'a [u8],
    },
}

impl<'a> Instruction<'a> {
    /// The instruction of a packet; `None` if it is not one, or its parameters do not fit it.
    pub fn parse(packet: Packet<'a>) -> Option<Self> {
        let parameters = packet.parameters();
        Some(match (packet.code(), parameters) {
            (0x01, []) => Self::Ping,
            (0x02, &[address, length]) => Self::Read { address, length },
            (0x03, &[address, ref data @ ..]) if !data.is_empty() => Self::Write { address, data },
            (0x04, &[address, ref data @ ..]) if !data.is_empty() => {
                Self::RegWrite { address, data }
            }
            (0x05, []) => Self::Action,
            (0x06, []) => Self::Recover,
            (0x08, []) => Self::Restart,
            (0x09, []) => Self::BackUp,
            (0x0A, []) => Self::ResetTurns,
            (0x0B, []) => Self::Calibrate(None),
            (0x0B, &[first, second]) => Self::Calibrate(Some([first, second])),
            (0x82, &[address, length, ref ids @ ..]) if !ids.is_empty() => Self::SyncRead {
                address,
                length,
                ids,
            },
            (0x83, &[address, length, ref items @ ..])
                if length > 0
                    && !items.is_empty()
                    && items.len() % (usize::from(length) + 1) == 0 =>
            {
                Self::SyncWrite {
                    address,
                    length,
                    items,
                }
            }
            _ => return None,
        })
    }
}
