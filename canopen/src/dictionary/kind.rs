//! What an object is and who may do what with it, in one byte.

use super::DataType;

/// Who may read and write an object (CiA 301, 7.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Access {
    /// Never changes: answered from the table.
    Const,
    /// Read only.
    Read,
    /// Write only.
    Write,
    /// Read and write.
    ReadWrite,
}

/// In which PDOs an object may be mapped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Mapping {
    /// In none.
    None,
    /// In RPDOs.
    Receive,
    /// In TPDOs.
    Transmit,
    /// In both.
    Both,
}

/// Code of a data type for UNSIGNED32 to which the node-ID is added.
const WITH_NODE_ID: u8 = 15;
/// Code of what cannot be: the check of the dictionary finds it.
const IMPOSSIBLE: u8 = 0;

/// Who may do what with an object, in four bits: access in the upper two, mapping in the lower two.
/// Six of these combinations make no sense, as a PDO cannot write what cannot be written; they
/// stand for the six that do and are locked. `None` where it makes no sense.
const fn rights(access: Access, mapping: Mapping, guarded: bool) -> Option<u8> {
    use {Access as A, Mapping as M};
    Some(match (guarded, access, mapping) {
        (_, A::Const | A::Read, M::Receive | M::Both) => return None,
        (_, A::Write, M::Transmit | M::Both) => return None,
        (true, A::Write, M::None) => 0b0001,
        (true, A::Write, M::Receive) => 0b0011,
        (true, A::ReadWrite, M::None) => 0b0101,
        (true, A::ReadWrite, M::Receive) => 0b0111,
        (true, A::ReadWrite, M::Transmit) => 0b1010,
        (true, A::ReadWrite, M::Both) => 0b1011,
        (_, access, mapping) => (access as u8) << 2 | mapping as u8,
    })
}

/// What each of the sixteen rights is: access above mapping above the lock, which is the lowest
/// bit.
const RIGHTS: [u8; 16] = {
    let mut table = [0; 16];
    let mut code = 0;
    while code < 32 {
        let (access, mapping) = (Access::of(code >> 3), Mapping::of(code >> 1));
        let guarded = code & 1 == 1;
        // A lock on what cannot be written says nothing.
        let locks = guarded && matches!(access, Access::Write | Access::ReadWrite);
        if let Some(rights) = rights(access, mapping, guarded)
            && guarded == locks
        {
            table[rights as usize] = code;
        }
        code += 1;
    }
    table
};

impl Access {
    /// Of the lower two bits.
    const fn of(bits: u8) -> Self {
        match bits & 3 {
            0 => Self::Const,
            1 => Self::Read,
            2 => Self::Write,
            _ => Self::ReadWrite,
        }
    }
}

impl Mapping {
    /// Of the lower two bits.
    const fn of(bits: u8) -> Self {
        match bits & 3 {
            0 => Self::None,
            1 => Self::Receive,
            2 => Self::Transmit,
            _ => Self::Both,
        }
    }
}

/// The data type's code in the upper half, rights in the lower one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kind(u8);

impl Kind {
    pub const fn new(data_type: DataType, access: Access) -> Self {
        Self(data_type.code() << 4).with_rights(access, Mapping::None, false)
    }

    const fn with_rights(self, access: Access, mapping: Mapping, guarded: bool) -> Self {
        match rights(access, mapping, guarded) {
            Some(rights) => Self(self.0 & 0xF0 | rights),
            None => Self(IMPOSSIBLE << 4),
        }
    }

    pub const fn mappable(self, mapping: Mapping) -> Self {
        self.with_rights(self.access(), mapping, self.is_guarded())
    }

    pub const fn guarded(self) -> Self {
        self.with_rights(self.access(), self.mapping(), true)
    }

    /// The node-ID is added to its value, which must be an UNSIGNED32.
    pub const fn with_node_id(self) -> Self {
        let is_u32 = matches!(self.data_type(), DataType::U32);
        let code = if is_u32 { WITH_NODE_ID } else { IMPOSSIBLE };
        Self(code << 4 | self.0 & 15)
    }

    pub const fn has_node_id(self) -> bool {
        self.0 >> 4 == WITH_NODE_ID
    }

    /// Whether it was made of what does not go together.
    pub const fn is_impossible(self) -> bool {
        self.0 >> 4 == IMPOSSIBLE
    }

    pub const fn data_type(self) -> DataType {
        DataType::from_code(self.0 >> 4)
    }

    const fn rights(self) -> u8 {
        RIGHTS[(self.0 & 15) as usize]
    }

    pub const fn access(self) -> Access {
        Access::of(self.rights() >> 3)
    }

    pub const fn mapping(self) -> Mapping {
        Mapping::of(self.rights() >> 1)
    }

    pub const fn is_guarded(self) -> bool {
        self.rights() & 1 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_combinations_of_rights_come_back_and_the_others_are_refused() {
        let mut seen = [false; 16];
        for code in 0..32 {
            let (access, mapping) = (Access::of(code >> 3), Mapping::of(code >> 1));
            let guarded = code & 1 == 1;
            let Some(bits) = rights(access, mapping, guarded) else {
                continue;
            };
            let mut kind = Kind::new(DataType::U8, access).mappable(mapping);
            kind = if guarded { kind.guarded() } else { kind };
            assert_eq!((kind.access(), kind.mapping()), (access, mapping));
            let writable = matches!(access, Access::Write | Access::ReadWrite);
            assert_eq!(kind.is_guarded(), guarded && writable);
            assert!(!kind.is_impossible());
            seen[usize::from(bits)] = true;
        }
        assert_eq!(seen, [true; 16]);
    }
}
