//! Instructions in plain form.

/// Bytes of a servo in a bulk instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Item<'a> {
    /// The servo.
    pub id: u8,
    /// First address.
    pub address: u16,
    /// Number of bytes.
    pub length: u16,
    /// The bytes of a write.
    pub data: &'a [u8],
}

/// What an instruction packet asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instruction<'a> {
    /// Model and firmware.
    Ping,
    /// The bytes from an address on.
    Read {
        /// First address.
        address: u16,
        /// Number of bytes.
        length: u16,
    },
    /// Bytes to an address.
    Write {
        /// First address.
        address: u16,
        /// The bytes.
        data: &'a [u8],
    },
    /// The same at the next action.
    RegWrite {
        /// First address.
        address: u16,
        /// The bytes.
        data: &'a [u8],
    },
    /// The registered write.
    Action,
    /// The values of a new servo: FFh all, 1 all but the ID, 2 all but ID and bit rate.
    FactoryReset(u8),
    /// A start.
    Reboot,
    /// The position within a turn.
    Clear,
    /// Present values as the backup.
    BackUp,
    /// The values of the backup.
    Restore,
    /// The same bytes of several servos.
    SyncRead {
        /// First address.
        address: u16,
        /// Number of bytes.
        length: u16,
        /// The servos.
        ids: &'a [u8],
        /// Whether they answer in one packet.
        is_fast: bool,
    },
    /// Bytes to the same address of several servos.
    SyncWrite {
        /// First address.
        address: u16,
        /// Number of bytes of each.
        length: u16,
        /// For each servo its ID and its bytes.
        items: &'a [u8],
    },
    /// Bytes of several servos.
    BulkRead {
        /// For each servo ID, address and length.
        items: &'a [u8],
        /// Whether they answer in one packet.
        is_fast: bool,
    },
    /// Bytes to several servos.
    BulkWrite {
        /// For each servo ID, address, length and its bytes.
        items: &'a [u8],
    },
}

/// What makes a reset of the position, or a backup, valid beside its option.
const CLEAR: [u8; 4] = [0x44, 0x58, 0x4C, 0x22];
const BACKUP: [u8; 4] = [0x43, 0x54, 0x52, 0x4C];

impl<'a> Instruction<'a> {
    /// The instruction of the body of a packet; `None` if it is not one, or its parameters do not
    /// fit it.
    pub fn parse(body: &'a [u8]) -> Option<Self> {
        let (instruction, parameters) = body.split_first()?;
        match instruction {
            0x82 | 0x83 | 0x8A => return Self::parse_sync(*instruction, parameters),
            0x92 | 0x93 | 0x9A => return Self::parse_bulk(*instruction, parameters),
            _ => {}
        }
        Some(match (instruction, parameters) {
            (0x01, []) => Self::Ping,
            (0x02, &[a, b, c, d]) => Self::Read {
                address: u16::from_le_bytes([a, b]),
                length: u16::from_le_bytes([c, d]),
            },
            (0x03, &[a, b, ref data @ ..]) if !data.is_empty() => Self::Write {
                address: u16::from_le_bytes([a, b]),
                data,
            },
            (0x04, &[a, b, ref data @ ..]) if !data.is_empty() => Self::RegWrite {
                address: u16::from_le_bytes([a, b]),
                data,
            },
            (0x05, []) => Self::Action,
            (0x06, &[option @ (0xFF | 1 | 2)]) => Self::FactoryReset(option),
            (0x08, []) => Self::Reboot,
            (0x10, [1, rest @ ..]) if *rest == CLEAR => Self::Clear,
            (0x20, [1, rest @ ..]) if *rest == BACKUP => Self::BackUp,
            (0x20, [2, rest @ ..]) if *rest == BACKUP => Self::Restore,
            _ => return None,
        })
    }

    fn parse_sync(instruction: u8, parameters: &'a [u8]) -> Option<Self> {
        let &[a, b, c, d, ref rest @ ..] = parameters else {
            return None;
        };
        let (address, length) = (u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]));
        if rest.is_empty() || length == 0 {
            return None;
        }
        if instruction != 0x83 {
            let (ids, is_fast) = (rest, instruction == 0x8A);
            return Some(Self::SyncRead {
                address,
                length,
                ids,
                is_fast,
            });
        }
        let is_whole = rest.len() % (usize::from(length) + 1) == 0;
        is_whole.then_some(Self::SyncWrite {
            address,
            length,
            items: rest,
        })
    }

    fn parse_bulk(instruction: u8, items: &'a [u8]) -> Option<Self> {
        let has_data = instruction == 0x93;
        let mut rest = items;
        while !rest.is_empty() {
            (_, rest) = Item::split(rest, has_data)?;
        }
        match instruction {
            _ if items.is_empty() => None,
            0x93 => Some(Self::BulkWrite { items }),
            _ => Some(Self::BulkRead {
                items,
                is_fast: instruction == 0x9A,
            }),
        }
    }
}

impl<'a> Item<'a> {
    /// The first item of those of a bulk instruction, and the others.
    pub fn split(bytes: &'a [u8], has_data: bool) -> Option<(Self, &'a [u8])> {
        let &[id, a, b, c, d, ref rest @ ..] = bytes else {
            return None;
        };
        let length = u16::from_le_bytes([c, d]);
        let count = if has_data { usize::from(length) } else { 0 };
        let (data, rest) = rest.split_at_checked(count)?;
        let address = u16::from_le_bytes([a, b]);
        let item = Self {
            id,
            address,
            length,
            data,
        };
        (length > 0).then_some((item, rest))
    }

    /// All items.
    pub fn all(bytes: &'a [u8], has_data: bool) -> impl Iterator<Item = Self> + Clone {
        let mut rest = bytes;
        core::iter::from_fn(move || {
            let (item, after) = Self::split(rest, has_data)?;
            rest = after;
            Some(item)
        })
    }
}
