//! Memory of the second emulator, which its host reads and writes while it runs.

use std::alloc::{Layout, alloc_zeroed, dealloc};
use std::ptr::{self, NonNull};

/// Alignment of a region, bytes: that of the emulator's pages.
const PAGE: usize = 4096;

/// A region of plain memory.
#[derive(Debug)]
struct Block {
    start: u32,
    layout: Layout,
    /// Its first byte, as an exposed address.
    bytes: usize,
}

impl Block {
    /// The byte at this offset.
    fn at(&self, offset: usize) -> *mut u8 {
        ptr::with_exposed_provenance_mut(self.bytes + offset)
    }
}

/// Regions of plain memory at addresses of the processor. They do not move.
#[derive(Debug, Default)]
pub struct Memory {
    blocks: Vec<Block>,
}

#[allow(
    unsafe_code,
    reason = "generated code writes this memory, so that no reference to it may exist; each block states why it is sound"
)]
impl Memory {
    /// Adds a region of zeros; returns its first byte.
    ///
    /// # Panics
    /// If the region is empty or there is no memory.
    pub fn add(&mut self, start: u32, length: usize) -> NonNull<u8> {
        let layout = Layout::from_size_align(length, PAGE).expect("a region of the chip's memory");
        assert!(length > 0);
        // SAFETY: the layout is not empty.
        let bytes = NonNull::new(unsafe { alloc_zeroed(layout) }).expect("memory");
        self.blocks.push(Block {
            start,
            layout,
            bytes: bytes.as_ptr().expose_provenance(),
        });
        bytes
    }

    /// The byte at this address, if `length` bytes from there on are in a region.
    fn at(&self, address: u32, length: usize) -> Option<*mut u8> {
        self.blocks.iter().find_map(|block| {
            let offset = address.checked_sub(block.start)? as usize;
            (offset + length <= block.layout.size()).then(|| block.at(offset))
        })
    }

    /// Copies the bytes from this address on; returns whether a region contains them.
    pub fn read(&self, address: u32, into: &mut [u8]) -> bool {
        let Some(bytes) = self.at(address, into.len()) else {
            return false;
        };
        // SAFETY: `at` returns a range of a block, and the emulator does not run meanwhile.
        unsafe { ptr::copy_nonoverlapping(bytes, into.as_mut_ptr(), into.len()) };
        true
    }

    /// Writes these bytes; returns whether a region contains them.
    pub fn write(&self, address: u32, from: &[u8]) -> bool {
        let Some(bytes) = self.at(address, from.len()) else {
            return false;
        };
        // SAFETY: `at` returns a range of a block, and the emulator does not run meanwhile.
        unsafe { ptr::copy_nonoverlapping(from.as_ptr(), bytes, from.len()) };
        true
    }

    /// A word; `None` where there is no memory.
    pub fn word(&self, address: u32) -> Option<u32> {
        let mut bytes = [0; 4];
        self.read(address, &mut bytes)
            .then(|| u32::from_le_bytes(bytes))
    }

    /// A halfword; `None` where there is no memory.
    pub fn half(&self, address: u32) -> Option<u16> {
        let mut bytes = [0; 2];
        self.read(address, &mut bytes)
            .then(|| u16::from_le_bytes(bytes))
    }

    /// Calls a function with all bytes of the region that begins at this address.
    pub fn with<R>(&self, start: u32, f: impl FnOnce(&mut [u8]) -> R) -> Option<R> {
        let block = self.blocks.iter().find(|block| block.start == start)?;
        // SAFETY: the block is owned, and the emulator does not run while `f` has it.
        let bytes = unsafe { std::slice::from_raw_parts_mut(block.at(0), block.layout.size()) };
        Some(f(bytes))
    }
}

impl Drop for Memory {
    #[allow(unsafe_code, reason = "returns what `add` allocated")]
    fn drop(&mut self) {
        for block in &self.blocks {
            // SAFETY: allocated with this layout, and the emulator is closed before.
            unsafe { dealloc(block.at(0), block.layout) };
        }
    }
}
