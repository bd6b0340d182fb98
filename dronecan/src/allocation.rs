//! Dynamic allocation of a node-ID (specification, section 6.3): the node sends its unique
//! identifier in three parts, each after the allocator has repeated those before.

use crate::{Payload, Reader};

/// Bytes of the unique identifier in a request.
const PART: usize = 6;

/// The time between requests, us: at least this, and at most as much again.
const REQUEST_US: u64 = 600_000;
const REQUEST_SPREAD_US: u64 = 400_000;
/// The longest time before a further part, us.
const FOLLOW_UP_US: u64 = 400_000;

/// The allocation of a node-ID.
#[derive(Debug)]
pub(crate) struct Allocation {
    /// Bytes of the unique identifier that an allocator has repeated.
    known: usize,
    due_us: u64,
    random: u32,
}

impl Allocation {
    /// An allocation whose first request is due after a random time.
    pub fn new(unique_id: &[u8; 16], now_us: u64) -> Self {
        let seed = unique_id.iter().fold(now_us as u32, |seed, byte| {
            (seed ^ u32::from(*byte)).wrapping_mul(0x0100_0193)
        });
        let mut allocation = Self {
            known: 0,
            due_us: 0,
            random: seed | 1,
        };
        allocation.wait(now_us);
        allocation
    }

    /// The payload of a request, if one is due.
    pub fn poll(&mut self, unique_id: &[u8; 16], now_us: u64) -> Option<Payload> {
        if now_us < self.due_us {
            return None;
        }
        let part = unique_id.iter().skip(self.known).take(PART);
        let mut payload = Payload::new();
        // No node-ID is preferred.
        payload.unsigned(0, 7).unsigned((self.known == 0).into(), 1);
        for byte in part {
            payload.put(&[*byte]);
        }
        self.known = 0;
        self.wait(now_us);
        Some(payload)
    }

    /// Takes an allocation message; returns the node-ID if it is for this node.
    pub fn receive(
        &mut self,
        unique_id: &[u8; 16],
        payload: &[u8],
        from_allocator: bool,
        now_us: u64,
    ) -> Option<u8> {
        self.known = 0;
        self.wait(now_us);
        let mut reader = Reader::new(payload);
        let node_id = reader.unsigned(7) as u8;
        let repeated = reader.rest();
        if !from_allocator || repeated.is_empty() || !unique_id.starts_with(repeated) {
            return None;
        }
        if repeated.len() == unique_id.len() {
            return (1..=MOST).contains(&node_id).then_some(node_id);
        }
        self.known = repeated.len();
        self.due_us = now_us.wrapping_add(self.random_below(FOLLOW_UP_US));
        None
    }

    fn wait(&mut self, now_us: u64) {
        let more = self.random_below(REQUEST_SPREAD_US);
        self.due_us = now_us.wrapping_add(REQUEST_US + more);
    }

    /// By xorshift.
    fn random_below(&mut self, end: u64) -> u64 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 17;
        self.random ^= self.random << 5;
        (u64::from(self.random) * end) >> 32
    }
}

/// The largest node-ID; 126 and 127 are for tools.
pub(crate) const MOST: u8 = 125;
