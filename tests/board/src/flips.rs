//! Bit flips that the board notices by its checks alone.

use virtual_board::faults::{Fault, MemoryLocation};

use crate::program::firmware;

/// A bit of the CANopen device flips: the highest one of its last byte.
///
/// # Panics
/// If the program has no such variable.
pub fn device_flip() -> Fault {
    let device = firmware().symbol_containing("init_device");
    let place = MemoryLocation::Address(device.expect("a variable").end - 1);
    Fault::FlipRam { place, bit: 7 }
}

/// A bit of the program flips that is used at the start alone: the initial values of variables are
/// behind the constants.
pub fn program_flip() -> Fault {
    let place = MemoryLocation::Address(firmware().section(".rodata").end);
    Fault::FlipFlash { place, bit: 0 }
}
