//! Bit flips that the board detects by its checks alone.

use virtual_board::faults::{Fault, MemoryLocation};

use crate::program::firmware;

/// Offset in the memory of the loop, and a bit, of the number of the control period in the first
/// copy.
const IN_FIRST_COPY: (u64, u32) = (0x1d0, 1);

/// Address and bit of the number of the control period in the first copy of the control loop.
///
/// # Panics
/// If the program has no such memory.
pub fn in_first_copy() -> (u64, u32) {
    let (offset, bit) = IN_FIRST_COPY;
    let memory = firmware().address("CONTROL_LOOP").expect("a symbol");
    (memory + offset, bit)
}

/// A bit of the first copy of the control loop flips.
///
/// # Panics
/// If the program has no such variable.
pub fn loop_flip() -> Fault {
    let (address, bit) = in_first_copy();
    let place = MemoryLocation::Address(address);
    Fault::FlipRam { place, bit }
}

/// A bit of the program flips that is used at the start alone: the initial values of variables are
/// behind the constants.
pub fn program_flip() -> Fault {
    let place = MemoryLocation::Address(firmware().section(".rodata").end);
    Fault::FlipFlash { place, bit: 0 }
}
