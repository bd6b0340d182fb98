//! What the array does at a time.

use rigless::device::DeviceContext;
use rigless::soc::Width;

/// A change of the array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operation {
    /// Sets all bits of a range.
    Erase {
        /// First address.
        base: u64,
        /// Bytes.
        size: u64,
    },
    /// Clears bits of a unit.
    Program {
        /// Its address.
        address: u64,
        /// 1, 2, 4 or 8 bytes.
        bytes: u8,
        /// What it is to hold.
        value: u64,
    },
}

/// An operation with its time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Started {
    /// What is done.
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
}

pub(super) fn width(bytes: u8) -> Width {
    match bytes {
        1 => Width::W8,
        2 => Width::W16,
        4 => Width::W32,
        _ => Width::W64,
    }
}

/// Makes a range hold what `word` says of each double word.
pub(super) fn fill(
    base: u64,
    size: u64,
    context: &mut DeviceContext<'_>,
    mut word: impl FnMut(u64) -> u64,
) {
    for address in (base..base + size).step_by(8) {
        context.program(address, Width::W64, word(address), IGNORED);
    }
}

/// Token of accesses whose answer nobody waits for.
pub(super) const IGNORED: u64 = 0;
