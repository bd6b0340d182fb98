//! Observation of the emulated core: its registers, its memory and its accesses to the bus.
//!
//! An [`Observer`] runs the core in place of the emulator, so that it inspects the core before and
//! after each stretch of instructions, and every access to a peripheral through its own bus.

mod layer;

use std::fmt::Debug;
use std::sync::{Arc, Mutex, MutexGuard};

pub use layer::{BusLayer, Layered};
pub use rigless::emulator::{
    Access, AccessKind, Checked, CoreBus, Exit, InterruptLine, Processor, Queued,
};
pub use rigless::soc::Width;
pub use rigless::time::VirtualNanos;

/// A write of a register: its number for GDB, and the word.
pub type RegisterWrite = (usize, u32);

/// Runs the core of a board.
pub trait Observer: Send + Debug {
    /// Runs at most this number of instructions on this bus, as [`Processor::run`] does.
    fn run(
        &mut self,
        core: &mut dyn Processor,
        memory: &Memory,
        budget: u32,
        bus: &mut dyn CoreBus,
    ) -> (Exit, u64);

    /// The registers that are to be written after a run.
    fn take_register_writes(&mut self) -> Vec<RegisterWrite> {
        Vec::new()
    }

    /// The core was reset.
    fn after_reset(&mut self);
}

/// An observer, and its results after the run.
pub type SharedObserver = Arc<Mutex<dyn Observer>>;

/// The observer; a panic of its run has already ended the test.
pub(crate) fn lock(observer: &SharedObserver) -> MutexGuard<'_, dyn Observer + 'static> {
    observer
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// A region of the core's memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Region {
    /// Address of its first byte.
    pub start: u64,
    /// Length, bytes.
    pub length: usize,
    /// Whether instructions can write it.
    pub is_writable: bool,
    /// Address of its first byte in this process.
    host: usize,
}

/// The memory of the core: flash and RAM, without the registers of the peripherals.
#[derive(Debug, Default)]
pub struct Memory {
    regions: Vec<Region>,
}

#[allow(
    unsafe_code,
    reason = "the emulator lends its memory by raw pointers; each block states why it is sound"
)]
impl Memory {
    /// Adds a region.
    ///
    /// # Safety
    /// As [`Processor::map`]: `host` is valid for reads of `length` bytes as long as this value
    /// exists, and nothing writes them while a method of this value runs.
    pub(crate) unsafe fn map(&mut self, start: u64, length: u64, host: *mut u8, writable: bool) {
        self.regions.push(Region {
            start,
            length: length as usize,
            is_writable: writable,
            host: host.expose_provenance(),
        });
    }

    /// Has a core map all regions.
    ///
    /// # Safety
    /// As [`Self::map`], as long as this core exists or maps other memory in their place.
    pub(crate) unsafe fn map_for(&self, core: &mut dyn Processor) {
        for region in &self.regions {
            let host = std::ptr::with_exposed_provenance_mut(region.host);
            // SAFETY: the caller's promise is that of `map`.
            unsafe {
                core.map(region.start, region.length as u64, host, region.is_writable);
            }
        }
    }

    /// The regions.
    pub fn regions(&self) -> &[Region] {
        &self.regions
    }

    /// The region and the offset of this range; `None` if no region contains it.
    fn find(&self, address: u64, length: usize) -> Option<(&Region, usize)> {
        self.regions.iter().find_map(|region| {
            let offset = usize::try_from(address.checked_sub(region.start)?).ok()?;
            let is_inside = offset.checked_add(length)? <= region.length;
            is_inside.then_some((region, offset))
        })
    }

    /// Calls a function with the bytes of a range; `None` if no region contains it.
    fn with<R>(&self, address: u64, length: usize, f: impl FnOnce(&[u8]) -> R) -> Option<R> {
        let (region, offset) = self.find(address, length)?;
        let host = std::ptr::with_exposed_provenance::<u8>(region.host + offset);
        // SAFETY: the range is within a region, whose bytes the promise of `map` makes valid and
        // unchanged while `f`, which has no access to the core, runs.
        let bytes = unsafe { std::slice::from_raw_parts(host, length) };
        Some(f(bytes))
    }

    /// Copies the bytes from this address on; returns whether a region contains them.
    pub fn copy(&self, address: u64, into: &mut [u8]) -> bool {
        let length = into.len();
        let copied = self.with(address, length, |bytes| into.copy_from_slice(bytes));
        copied.is_some()
    }

    /// Offset of the first byte from this address on that is not that of `expected`; `None` if all
    /// are, or no region contains them.
    pub fn first_difference(&self, address: u64, expected: &[u8]) -> Option<usize> {
        self.with(address, expected.len(), |bytes| {
            if bytes == expected {
                return None;
            }
            bytes.iter().zip(expected).position(|(a, b)| a != b)
        })?
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[allow(unsafe_code, reason = "lends memory that outlives the view")]
    fn a_range_is_read_within_a_region_and_not_beyond_it() {
        let mut bytes = [1_u8, 2, 3, 4];
        let mut memory = Memory::default();
        // SAFETY: `bytes` exists as long as `memory` and is not written.
        unsafe { memory.map(0x2000_0000, 4, bytes.as_mut_ptr(), true) };
        let mut found = [0; 2];
        assert!(memory.copy(0x2000_0001, &mut found));
        assert_eq!(found, [2, 3]);
        assert!(!memory.copy(0x2000_0003, &mut found));
        assert!(!memory.copy(0x1fff_ffff, &mut found));
        assert_eq!(memory.first_difference(0x2000_0000, &[1, 2, 9, 4]), Some(2));
        assert_eq!(memory.first_difference(0x2000_0000, &[1, 2, 3, 4]), None);
    }
}
