//! Declaration of one entry of the object dictionary.

use super::kind::Kind;
use super::{Access, Address, DataType, Mapping};

/// Lower and upper limit of an object of at most 32 bits, as bits of its data type.
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
/// object that the server does not hold. Used at compile time only:
/// [`dictionary!`](crate::dictionary!) packs all entries.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    pub(super) address: Address,
    pub(super) kind: Kind,
    pub(super) value: u32,
    pub(super) limits: Option<&'static Limits>,
}

impl Entry {
    /// An entry that is not mappable, with value 0 and without limits.
    #[must_use]
    pub const fn new(index: u16, sub: u8, data_type: DataType, access: Access) -> Self {
        Self {
            address: Address::new(index, sub),
            kind: Kind::new(data_type, access),
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
        self.kind = self.kind.with_node_id();
        self
    }

    /// Allows mapping into PDOs.
    #[must_use]
    pub const fn mappable(mut self, mapping: Mapping) -> Self {
        self.kind = self.kind.mappable(mapping);
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
        self.kind = self.kind.guarded();
        self
    }
}
