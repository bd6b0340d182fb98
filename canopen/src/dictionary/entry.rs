//! One entry of the object dictionary.

use super::{Address, DataType};

/// Access of the SDO client to an object (CiA 301, 7.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Constant: answered from the dictionary.
    Const,
    /// Read only.
    Read,
    /// Write only.
    Write,
    /// Read and write.
    ReadWrite,
}

/// The kind of PDO into which an object may be mapped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mapping {
    /// Not mappable.
    None,
    /// RPDOs.
    Receive,
    /// TPDOs.
    Transmit,
    /// RPDOs and TPDOs.
    Both,
}

/// Lower and upper limit of an object of at most 32 bits, as bits of its data type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    minimum: u32,
    maximum: u32,
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

    /// For REAL32; NaN is outside the limits.
    #[must_use]
    pub const fn real(minimum: f32, maximum: f32) -> Self {
        Self {
            minimum: minimum.to_bits(),
            maximum: maximum.to_bits(),
        }
    }
}

/// Constant description of one object of the dictionary. The application holds the value of every
/// object that the server does not hold.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    address: Address,
    data_type: DataType,
    access: Access,
    mapping: Mapping,
    is_guarded: bool,
    has_node_id: bool,
    number: u16,
    value: u32,
    limits: Option<&'static Limits>,
}

/// Declaration.
impl Entry {
    /// An entry that is not mappable, with value 0 and without limits.
    #[must_use]
    pub const fn new(index: u16, sub: u8, data_type: DataType, access: Access) -> Self {
        Self {
            address: Address::new(index, sub),
            data_type,
            access,
            mapping: Mapping::None,
            is_guarded: false,
            has_node_id: false,
            number: 0,
            value: 0,
            limits: None,
        }
    }

    /// Sets the value of a constant, or the default of an object held by the server, as bits of the
    /// data type; for a writable string, its maximum length.
    #[must_use]
    pub const fn value(mut self, value: u32) -> Self {
        self.value = value;
        self
    }

    /// As [`Entry::value`] of an UNSIGNED32 to which the node-ID is added (`$NODEID` of an EDS).
    #[must_use]
    pub const fn value_with_node_id(mut self, value: u32) -> Self {
        self.value = value;
        self.has_node_id = true;
        self
    }

    /// Sets a number by which the application finds the value of the object without a search.
    #[must_use]
    pub const fn numbered(mut self, number: u16) -> Self {
        self.number = number;
        self
    }

    /// Allows mapping into PDOs.
    #[must_use]
    pub const fn mappable(mut self, mapping: Mapping) -> Self {
        self.mapping = mapping;
        self
    }

    /// Sets limits; a write of a value outside them is refused.
    #[must_use]
    pub const fn limits(mut self, limits: &'static Limits) -> Self {
        self.limits = Some(limits);
        self
    }

    /// Write-protects the object while [`Application::guarded`](crate::Application::guarded) is
    /// true: for protection limits and identity, which must not change while the drive is enabled.
    #[must_use]
    pub const fn guarded(mut self) -> Self {
        self.is_guarded = true;
        self
    }
}

/// Properties.
impl Entry {
    /// Index and sub-index.
    #[must_use]
    pub const fn address(&self) -> Address {
        self.address
    }

    /// The number that [`Entry::numbered`] has set, 0 by default.
    #[must_use]
    pub const fn number(&self) -> u16 {
        self.number
    }

    /// Data type.
    #[must_use]
    pub const fn data_type(&self) -> DataType {
        self.data_type
    }

    /// Access of the SDO client.
    #[must_use]
    pub const fn access(&self) -> Access {
        self.access
    }

    /// The kind of PDO into which it may be mapped.
    #[must_use]
    pub const fn mapping(&self) -> Mapping {
        self.mapping
    }

    /// Whether the node-ID is added to its value.
    #[must_use]
    pub const fn has_node_id(&self) -> bool {
        self.has_node_id
    }

    /// The value of a constant, or the default of an object, as bits of its data type, for this
    /// node-ID.
    #[must_use]
    pub const fn default_value(&self, node_id: u8) -> u32 {
        if self.has_node_id {
            self.value.wrapping_add(node_id as u32)
        } else {
            self.value
        }
    }

    /// The smallest and the greatest value, if they are limited, as [`Limits`] has them.
    #[must_use]
    pub const fn limit_words(&self) -> Option<(u32, u32)> {
        match self.limits {
            Some(Limits { minimum, maximum }) => Some((*minimum, *maximum)),
            None => None,
        }
    }

    /// Limits, if any, in the order of [`DataType::ordered`].
    pub(crate) const fn ordered_limits(&self) -> Option<(i32, i32)> {
        let Some(Limits { minimum, maximum }) = self.limits else {
            return None;
        };
        let data_type = self.data_type;
        Some((data_type.ordered(*minimum), data_type.ordered(*maximum)))
    }

    pub(crate) const fn is_readable(&self) -> bool {
        !matches!(self.access, Access::Write)
    }

    pub(crate) const fn is_writable(&self) -> bool {
        matches!(self.access, Access::Write | Access::ReadWrite)
    }

    /// Whether the application may refuse writes: [`Entry::guarded`].
    #[must_use]
    pub const fn is_guarded(&self) -> bool {
        self.is_guarded
    }
}
