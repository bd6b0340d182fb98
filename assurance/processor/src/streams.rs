//! The memory that the DMA controller of the encoder and the converter writes.

use std::collections::VecDeque;

use crate::tap::Event;

/// DMA2: its streams begin at this address, with a distance of 24 bytes (RM0090, section 10.5).
const STREAMS: std::ops::Range<u32> = 0x4002_6410..0x4002_64d0;
const STRIDE: u32 = 0x18;

/// Offsets of configuration, number of items and address of the memory.
const CR: u32 = 0x00;
const NDTR: u32 = 0x04;
const M0AR: u32 = 0x0c;

/// Bits of the configuration.
const ENABLED: u32 = 1;
const DIRECTION: u32 = 0b11 << 6;

#[derive(Debug, Clone, Copy, Default)]
struct Stream {
    items: u32,
    address: u32,
}

/// What the streams write.
#[derive(Debug, Default)]
pub struct Streams {
    streams: [Stream; 8],
    ranges: Vec<(u32, u32)>,
    /// Number of ranges whose accesses are watched.
    watched: usize,
}

impl Streams {
    /// Considers these accesses.
    pub fn update(&mut self, log: &VecDeque<Event>) {
        let writes = log.iter().filter(|event| event.is_write);
        for event in writes.filter(|event| STREAMS.contains(&event.address)) {
            let offset = event.address - STREAMS.start;
            let stream = &mut self.streams[(offset / STRIDE) as usize];
            match offset % STRIDE {
                NDTR => stream.items = event.value,
                M0AR => stream.address = event.value,
                CR if event.value & ENABLED != 0 && event.value & DIRECTION == 0 => {
                    let item = 1 << (event.value >> 13 & 0b11);
                    let range = (stream.address, stream.items * item);
                    self.add(range);
                }
                _ => {}
            }
        }
    }

    fn add(&mut self, range: (u32, u32)) {
        if self.ranges.contains(&range) {
            return;
        }
        self.ranges.push(range);
    }

    /// First address and length of each range.
    pub fn ranges(&self) -> &[(u32, u32)] {
        &self.ranges
    }

    /// Whether this access begins in a range that is watched.
    pub fn is_watched(&self, address: u32) -> bool {
        let mut watched = self.ranges[..self.watched].iter();
        watched.any(|&(start, length)| (start..start + length).contains(&address))
    }

    /// Watches the ranges that have been added since the last call; returns them.
    pub fn watch_new(&mut self) -> &[(u32, u32)] {
        let first = self.watched;
        self.watched = self.ranges.len();
        &self.ranges[first..]
    }
}
