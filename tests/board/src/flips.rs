//! Bit flips that the board notices by its checks alone.

use virtual_board::faults::{Fault, MemoryLocation};

use crate::program::firmware;

/// Offset of a word of the first copy in the memory of the loop; no padding.
const IN_FIRST_COPY: u64 = 256;

/// A bit of the first copy of the control loop flips.
///
/// # Panics
/// If the program has no such variable.
pub fn loop_flip() -> Fault {
    let memory = firmware().address("CONTROL_LOOP").expect("a symbol");
    let place = MemoryLocation::Address(memory + IN_FIRST_COPY);
    Fault::FlipRam { place, bit: 3 }
}

/// A bit of the program flips that is used at the start alone: the initial values of variables are
/// behind the constants.
pub fn program_flip() -> Fault {
    let place = MemoryLocation::Address(firmware().section(".rodata").end);
    Fault::FlipFlash { place, bit: 0 }
}
