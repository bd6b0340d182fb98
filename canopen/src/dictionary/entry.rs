//! One entry of the object dictionary, as its author writes it.

use super::kind::Kind;
use super::{Access, Address, DataType, Mapping};

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
/// It is there for the compiler only: [`dictionary!`](crate::dictionary!) packs all of them.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    pub(super) address: Address,
    pub(super) kind: Kind,
    pub(super) value: u32,
    pub(super) limits: Option<&'static Limits>,
}

impl Entry {
    /// An entry that cannot be mapped, with value 0 and without limits.
    #[must_use]
    pub const fn new(index: u16, sub: u8, data_type: DataType, access: Access) -> Self {
        Self {
            address: Address::new(index, sub),
            kind: Kind::new(data_type, access),
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

    /// As [`Entry::value`] of an UNSIGNED32, to which the node-ID is added (`$NODEID` of an EDS).
    #[must_use]
    pub const fn value_with_node_id(mut self, value: u32) -> Self {
        self.value = value;
        self.kind = self.kind.with_node_id();
        self
    }

    /// May be mapped.
    #[must_use]
    pub const fn mappable(mut self, mapping: Mapping) -> Self {
        self.kind = self.kind.mappable(mapping);
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
        self.kind = self.kind.guarded();
        self
    }
}
