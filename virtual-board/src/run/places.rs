//! The places in memory that the faults of a plan change.

use std::ops::Range;

use super::{Firmware, RunError};
use crate::faults::{Fault, MemoryLocation, Planned};
use crate::flash;

/// Checks that the memory has the place of each fault that changes a bit.
///
/// # Errors
/// A symbol that the ELF file does not have, or an address that is not in this memory.
pub(super) fn check(
    plan: &[Planned],
    firmware: &Firmware,
    ram: &[(u64, u64)],
) -> Result<(), RunError> {
    let ram: Vec<_> = ram.iter().map(|(base, size)| *base..base + size).collect();
    let flash = flash::BASE..flash::BASE + flash::SIZE;
    let flash = std::slice::from_ref(&flash);
    for planned in plan {
        match &planned.fault {
            Fault::FlipRam { place, bit } => check_one("RAM", place, *bit, firmware, &ram)?,
            Fault::FlipFlash { place, bit } => check_one("flash", place, *bit, firmware, flash)?,
            _ => {}
        }
    }
    Ok(())
}

fn check_one(
    memory: &'static str,
    place: &MemoryLocation,
    bit: u32,
    firmware: &Firmware,
    ranges: &[Range<u64>],
) -> Result<(), RunError> {
    let address = match place {
        MemoryLocation::Address(address) => *address,
        MemoryLocation::Symbol(name) => firmware.address(name)?,
    };
    let byte = address.saturating_add(u64::from(bit / 8));
    if ranges.iter().any(|range| range.contains(&byte)) {
        return Ok(());
    }
    let expected = ranges
        .iter()
        .map(|range| format!("{:#x} to {:#x}", range.start, range.end - 1));
    Err(RunError::Place {
        memory,
        address: byte,
        expected: expected.collect::<Vec<_>>().join(" or "),
    })
}
