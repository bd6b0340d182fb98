//! Operations of the array.

use rigless::soc::Width;

/// A change of the array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operation {
    /// Sets all bits of a range.
    Erase {
        /// First address.
        base: u64,
        /// Bytes, a multiple of 8.
        size: u64,
    },
    /// Clears bits of a unit.
    Program {
        /// Its address.
        address: u64,
        /// Its width.
        width: Width,
        /// Value to program.
        value: u64,
    },
}

/// An operation with its time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Started {
    /// The operation.
    pub operation: Operation,
    /// Its start, ns.
    pub from_ns: u64,
    /// Its end, ns.
    pub until_ns: u64,
}

impl Operation {
    /// The first address that it changes.
    pub fn address(&self) -> u64 {
        match self {
            Self::Erase { base, .. } => *base,
            Self::Program { address, .. } => *address,
        }
    }

    /// Addresses of the units in which the array is read and written.
    pub(super) fn pieces(&self) -> impl Iterator<Item = u64> {
        let (base, size) = match self {
            Self::Erase { base, size } => (*base, *size),
            Self::Program { address, width, .. } => (*address, u64::from(width.bytes())),
        };
        let step = self.piece_width().bytes();
        (base..base + size).step_by(step as usize)
    }

    pub(super) fn piece_width(&self) -> Width {
        match self {
            Self::Erase { .. } => Width::W64,
            Self::Program { width, .. } => *width,
        }
    }

    /// Content of a unit after the operation.
    pub(super) fn complete(&self, held: u64) -> u64 {
        match self {
            Self::Erase { .. } => u64::MAX,
            Self::Program { value, .. } => held & value,
        }
    }
}
