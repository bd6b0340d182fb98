//! Allocation of node-IDs (specification, section 6.3): the allocator repeats the parts of a unique
//! identifier, and adds the node-ID to the whole one.

use std::collections::BTreeSet;

use dronecan::{Payload, Reader};

/// Bytes of a unique identifier.
const UNIQUE_ID: usize = 16;

/// Node-IDs that are given; 126 and 127 are for tools.
const GIVEN: std::ops::RangeInclusive<u8> = 1..=125;

/// An allocator.
#[derive(Debug, Default)]
pub struct Allocator {
    unique_id: Vec<u8>,
    /// Another allocator answers.
    is_redundant: bool,
}

/// An answer to a request.
#[derive(Debug)]
pub struct Answer {
    /// Its payload.
    pub payload: Payload,
    /// The node-ID that it gives.
    pub node: Option<u8>,
}

impl Allocator {
    /// The answer to an allocation message of this source, which is 0 for a request.
    pub fn answer(&mut self, payload: &[u8], source: u8, known: &BTreeSet<u8>) -> Option<Answer> {
        self.is_redundant |= source != 0;
        if self.is_redundant {
            return None;
        }
        let mut reader = Reader::new(payload);
        let (_, is_first) = (reader.unsigned(7), reader.unsigned(1) != 0);
        if is_first {
            self.unique_id.clear();
        } else if self.unique_id.is_empty() {
            return None;
        }
        self.unique_id.extend(reader.rest());
        let is_whole = self.unique_id.len() >= UNIQUE_ID;
        self.unique_id.truncate(UNIQUE_ID);
        let node = match is_whole {
            true => Some(GIVEN.clone().find(|node| !known.contains(node))?),
            false => None,
        };
        let mut payload = Payload::new();
        payload.unsigned(node.unwrap_or(0).into(), 7).unsigned(0, 1);
        payload.put(&self.unique_id);
        Some(Answer { payload, node })
    }
}
