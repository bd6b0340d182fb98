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

/// The node-ID is added to the value.
const NODE_ID: u8 = 1;
/// Not to be written while the application is [guarded](crate::Application::guarded).
const GUARDED: u8 = 2;

/// One entry of the object dictionary. The value of an object that the server does not keep itself
/// lives in the application; here stands what never changes.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    pub(crate) index: u16,
    pub(crate) sub: u8,
    data_type: DataType,
    access: Access,
    mapping: Mapping,
    flags: u8,
    value: u32,
    limits: Option<&'static Limits>,
}

impl Entry {
    /// An entry that cannot be mapped, with value 0 and without limits.
    #[must_use]
    pub const fn new(index: u16, sub: u8, data_type: DataType, access: Access) -> Self {
        Self {
            index,
            sub,
            data_type,
            access,
            mapping: Mapping::None,
            flags: 0,
            value: 0,
            limits: None,
        }
    }

    /// The value of a constant, or the default of an object that the server keeps, as bits of the
    /// data type; of a string that can be written its longest length.
    #[must_use]
    pub const fn value(mut self, value: u32) -> Self {
        self.value = value;
        self
    }

    /// As [`Entry::value`], to which the node-ID is added (`$NODEID` of an EDS).
    #[must_use]
    pub const fn value_with_node_id(mut self, value: u32) -> Self {
        self.value = value;
        self.flags |= NODE_ID;
        self
    }

    /// May be mapped.
    #[must_use]
    pub const fn mappable(mut self, mapping: Mapping) -> Self {
        self.mapping = mapping;
        self
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
    pub const fn guarded(mut self) -> Self {
        self.flags |= GUARDED;
        self
    }

    /// Index and sub-index.
    #[must_use]
    pub const fn address(&self) -> Address {
        Address::new(self.index, self.sub)
    }

    /// Data type.
    #[must_use]
    pub const fn data_type(&self) -> DataType {
        self.data_type
    }

    /// Who may read and write it.
    #[must_use]
    pub const fn access(&self) -> Access {
        self.access
    }

    /// In which PDOs it may be mapped.
    #[must_use]
    pub const fn mapping(&self) -> Mapping {
        self.mapping
    }

    pub(crate) const fn readable(&self) -> bool {
        !matches!(self.access, Access::Write)
    }

    pub(crate) const fn writable(&self) -> bool {
        matches!(self.access, Access::Write | Access::ReadWrite)
    }

    pub(crate) const fn is_guarded(&self) -> bool {
        self.flags & GUARDED != 0
    }

    /// The value in the table as bits of the data type, for a node of this node-ID.
    #[must_use]
    pub const fn value_for(&self, node_id: u8) -> u32 {
        if self.flags & NODE_ID == 0 {
            self.value
        } else {
            self.value.wrapping_add(node_id as u32)
        }
    }

    pub(crate) const fn limit_pair(&self) -> Option<(i64, i64)> {
        let Some(limits) = self.limits else {
            return None;
        };
        let signed = matches!(self.data_type, DataType::I8 | DataType::I16 | DataType::I32);
        let (low, high) = if signed {
            (limits.minimum as i32 as u64, limits.maximum as i32 as u64)
        } else {
            (limits.minimum as u64, limits.maximum as u64)
        };
        Some((self.data_type.ordered(low), self.data_type.ordered(high)))
    }
}
