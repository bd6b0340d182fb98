//! Routines that copy or clear memory.

use crate::program::Function;

/// A routine whose loops depend on the number of bytes that it is called with.
pub(crate) struct Routine {
    pub name: &'static str,
    /// The register that holds the number of bytes.
    pub register: u8,
    /// The number of bytes for which `loops.txt` has the bounds of its loops, and the maximum.
    pub most: u64,
}

/// All of them.
pub(crate) const ROUTINES: [Routine; 5] = [
    routine("memcpy", 2, 3),
    routine("__aeabi_memcpy4", 2, 264),
    routine("__aeabi_memcpy8", 2, 1584),
    routine("__aeabi_memclr4", 1, 264),
    routine("__aeabi_memclr8", 1, 115),
];

const fn routine(name: &'static str, register: u8, most: u64) -> Routine {
    Routine {
        name,
        register,
        most,
    }
}

impl Routine {
    /// The routine that a function is.
    pub fn of(function: &Function) -> Option<&'static Self> {
        ROUTINES.iter().find(|it| function.is_named(it.name))
    }
}
