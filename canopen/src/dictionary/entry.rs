//! One entry of the object dictionary.

use super::{Address, DataType};

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

/// Smallest and largest value of an object of at most 32 bits, as bits of its data type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    pub(crate) minimum: u32,
    pub(crate) maximum: u32,
}

impl Limits {
    /// For UNSIGNED8 to UNSIGNED32.
    #[must_use]
    pub const fn unsigned(minimum: u32, maximum: u32) -> Self {
        Self { minimum, maximum }
    }

    /// For INTEGER8 to INTEGER32.
    #[must_use]
    pub const fn signed(minimum: i32, maximum: i32) -> Self {
        Self {
            minimum: minimum as u32,
            maximum: maximum as u32,
        }
    }

    /// For REAL32; NaN is outside.
    #[must_use]
    pub const fn real(minimum: f32, maximum: f32) -> Self {
        Self {
            minimum: minimum.to_bits(),
            maximum: maximum.to_bits(),
        }
    }
}

/// One entry of the object dictionary. The value of an object that the server does not keep itself
/// lives in the application; here stands what never changes.
///
/// Twelve bytes on a processor of 32 bits: access, mapping and lock share four bits.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    pub(crate) index: u16,
    pub(crate) sub: u8,
    /// The data type's code in the upper half, rights in the lower one.
    kind: u8,
    value: u32,
    limits: Option<&'static Limits>,
}

/// Code of a data type for UNSIGNED32 to which the node-ID is added.
const WITH_NODE_ID: u8 = 15;
/// Code of what cannot be: the check of the dictionary finds it.
const IMPOSSIBLE: u8 = 0;

/// Who may do what with an object, in four bits: access in the upper two, mapping in the lower two. Six of
/// these combinations make no sense, as a PDO cannot write what cannot be written; they stand for the
/// six that do and are locked. `None` where it makes no sense.
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

/// What each of the sixteen rights is: access above mapping above the lock, which is the lowest bit.
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

impl Entry {
    /// An entry that cannot be mapped, with value 0 and without limits.
    #[must_use]
    pub const fn new(index: u16, sub: u8, data_type: DataType, access: Access) -> Self {
        Self {
            index,
            sub,
            kind: data_type.code() << 4,
            value: 0,
            limits: None,
        }
        .with_rights(access, Mapping::None, false)
    }

    const fn rights(&self) -> u8 {
        RIGHTS[(self.kind & 15) as usize]
    }

    const fn with_rights(mut self, access: Access, mapping: Mapping, guarded: bool) -> Self {
        self.kind = match rights(access, mapping, guarded) {
            Some(rights) => self.kind & 0xF0 | rights,
            None => IMPOSSIBLE << 4,
        };
        self
    }

    /// The value of a constant, or the default of an object that the server keeps, as bits of the
    /// data type; of a string that can be written its longest length.
    #[must_use]
    pub const fn value(mut self, value: u32) -> Self {
        self.value = value;
        self
    }

    /// As [`Entry::value`] of an UNSIGNED32, to which the node-ID is added (`$NODEID` of an EDS).
    #[must_use]
    pub const fn value_with_node_id(mut self, value: u32) -> Self {
        self.value = value;
        let is_u32 = matches!(self.data_type(), DataType::U32);
        let code = if is_u32 { WITH_NODE_ID } else { IMPOSSIBLE };
        self.kind = code << 4 | self.kind & 15;
        self
    }

    /// May be mapped.
    #[must_use]
    pub const fn mappable(self, mapping: Mapping) -> Self {
        self.with_rights(self.access(), mapping, self.is_guarded())
    }

    /// Writes outside are refused.
    #[must_use]
    pub const fn limits(mut self, limits: &'static Limits) -> Self {
        self.limits = Some(limits);
        self
    }

    /// Writes are refused while the application is [guarded](crate::Application::guarded): for
    /// protection limits and identity, which must not change under a drive that moves.
    #[must_use]
    pub const fn guarded(self) -> Self {
        self.with_rights(self.access(), self.mapping(), true)
    }

    /// Index and sub-index.
    #[must_use]
    pub const fn address(&self) -> Address {
        Address::new(self.index, self.sub)
    }

    /// Data type.
    #[must_use]
    pub const fn data_type(&self) -> DataType {
        DataType::from_code(self.kind >> 4)
    }

    /// Who may read and write it.
    #[must_use]
    pub const fn access(&self) -> Access {
        Access::of(self.rights() >> 3)
    }

    /// In which PDOs it may be mapped.
    #[must_use]
    pub const fn mapping(&self) -> Mapping {
        Mapping::of(self.rights() >> 1)
    }

    /// Whether it was made of what does not go together.
    pub(super) const fn is_impossible(&self) -> bool {
        self.kind >> 4 == IMPOSSIBLE
    }

    pub(crate) const fn readable(&self) -> bool {
        !matches!(self.access(), Access::Write)
    }

    pub(crate) const fn writable(&self) -> bool {
        matches!(self.access(), Access::Write | Access::ReadWrite)
    }

    pub(crate) const fn is_guarded(&self) -> bool {
        self.rights() & 1 == 1
    }

    /// The value in the table as bits of the data type, for a node of this node-ID.
    #[must_use]
    pub const fn value_for(&self, node_id: u8) -> u32 {
        if self.kind >> 4 == WITH_NODE_ID {
            self.value.wrapping_add(node_id as u32)
        } else {
            self.value
        }
    }

    pub(crate) const fn limit_pair(&self) -> Option<(i64, i64)> {
        let Some(limits) = self.limits else {
            return None;
        };
        let signed = matches!(
            self.data_type(),
            DataType::I8 | DataType::I16 | DataType::I32
        );
        let (low, high) = if signed {
            (limits.minimum as i32 as u64, limits.maximum as i32 as u64)
        } else {
            (limits.minimum as u64, limits.maximum as u64)
        };
        Some((
            self.data_type().ordered(low),
            self.data_type().ordered(high),
        ))
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
            let mut entry = Entry::new(0x2000, 0, DataType::U8, access).mappable(mapping);
            entry = if guarded { entry.guarded() } else { entry };
            assert_eq!((entry.access(), entry.mapping()), (access, mapping));
            assert_eq!(entry.is_guarded(), guarded && entry.writable());
            assert!(!entry.is_impossible());
            seen[usize::from(bits)] = true;
        }
        assert_eq!(seen, [true; 16]);
    }
}
