//! A packet's bytes.

use core::ops::{Deref, DerefMut};

/// The most bytes of a packet: those of the longest one that Robotis' SDK sends.
pub const CAPACITY: usize = 1024;

/// Up to [`CAPACITY`] bytes.
#[derive(Debug, Clone)]
pub struct Bytes {
    bytes: [u8; CAPACITY],
    length: usize,
}

impl Default for Bytes {
    fn default() -> Self {
        Self {
            bytes: [0; CAPACITY],
            length: 0,
        }
    }
}

impl Bytes {
    /// Appends a byte; what does not fit is left out, and `false` returned.
    pub fn push(&mut self, byte: u8) -> bool {
        let place = self.bytes.get_mut(self.length);
        let fits = place.map(|place| *place = byte).is_some();
        self.length += usize::from(fits);
        fits
    }

    /// Appends bytes, as [`Self::push`].
    pub fn extend(&mut self, bytes: &[u8]) -> bool {
        bytes.iter().all(|byte| self.push(*byte))
    }

    /// Removes bytes from the front.
    pub fn remove(&mut self, count: usize) {
        // Both are within the bytes, which the compiler sees here.
        let length = self.length.min(CAPACITY);
        let count = count.min(length);
        self.bytes.copy_within(count..length, 0);
        self.length = length - count;
    }

    /// Removes all bytes.
    pub fn clear(&mut self) {
        self.length = 0;
    }
}

impl Deref for Bytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

impl DerefMut for Bytes {
    fn deref_mut(&mut self) -> &mut [u8] {
        self.bytes.get_mut(..self.length).unwrap_or_default()
    }
}
