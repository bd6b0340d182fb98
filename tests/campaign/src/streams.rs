//! The memory that the DMA controllers read and write, which the core does not see.

use std::collections::BTreeSet;
use std::ops::Range;

/// The streams of both controllers begin at these addresses (RM0090, section 10.5).
const CONTROLLERS: [u64; 2] = [0x4002_6010, 0x4002_6410];
const STREAMS: u64 = 8;
const STRIDE: u64 = 0x18;

/// Offsets of the number of items and of both addresses of the memory.
const NDTR: u64 = 0x04;
const ADDRESSES: [u64; 2] = [0x0c, 0x10];

/// Size of the largest item, and the least number of items that is assumed: a transfer may have
/// counted down.
const ITEM_BYTES: u64 = 4;
const LEAST_ITEMS: u64 = 16;

/// What the streams may access.
#[derive(Debug, Default)]
pub struct Streams {
    /// Addresses of memory that a stream was given.
    starts: BTreeSet<u64>,
    /// The greatest number of items of any transfer.
    items: u64,
}

impl Streams {
    /// Considers the present registers.
    pub fn read(&mut self, mut register: impl FnMut(u64) -> u32) {
        for controller in CONTROLLERS {
            for offset in [NDTR].into_iter().chain(ADDRESSES) {
                for stream in 0..STREAMS {
                    let address = controller + stream * STRIDE + offset;
                    self.written(address, register(address).into());
                }
            }
        }
    }

    /// Considers a write to this address.
    pub fn written(&mut self, address: u64, value: u64) {
        let of_stream = |start: &u64| address.checked_sub(*start);
        let mut offsets = CONTROLLERS.iter().filter_map(of_stream);
        let Some(offset) = offsets.find(|offset| *offset < STREAMS * STRIDE) else {
            return;
        };
        match offset % STRIDE {
            NDTR => self.items = self.items.max(value & 0xffff),
            offset if ADDRESSES.contains(&offset) => {
                self.starts.insert(value);
            }
            _ => {}
        }
    }

    /// Whether a stream may access this byte.
    pub fn may_access(&self, address: u64) -> bool {
        let bytes = ITEM_BYTES * self.items.max(LEAST_ITEMS);
        let reach = |start: &u64| -> Range<u64> { *start..*start + bytes };
        self.starts
            .iter()
            .any(|start| reach(start).contains(&address))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_memory_of_a_stream_is_known_from_its_registers() {
        let mut streams = Streams::default();
        assert!(!streams.may_access(0x2000_0000));
        // M0AR and NDTR of stream 3 of DMA2.
        streams.written(0x4002_6464, 0x2000_0100);
        streams.written(0x4002_645c, 100);
        let found = [0x2000_00ff, 0x2000_0100, 0x2000_028f, 0x2000_0290];
        let found = found.map(|address| streams.may_access(address));
        assert_eq!(found, [false, true, true, false]);
        let mut read = Streams::default();
        read.read(|address| {
            if address == 0x4002_6020 {
                0x2000_0200
            } else {
                0
            }
        });
        assert!(read.may_access(0x2000_023f) && !read.may_access(0x2000_0240));
    }
}
