//! A position in a queue.

use core::sync::atomic::{AtomicU32, Ordering};

/// The number of elements that were written, or read, modulo 2^16. One word holds it twice, so that
/// a changed bit shows, and that both are read and written at once.
pub struct Position(AtomicU32);

impl Position {
    /// The start.
    pub const fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    /// The position, unless a bit of the word has changed.
    #[inline]
    pub fn get(&self) -> Option<u16> {
        let word = self.0.load(Ordering::Acquire);
        let position = word as u16;
        (u32::from(position) == word >> 16).then_some(position)
    }

    #[inline]
    pub fn set(&self, position: u16) {
        let word = u32::from(position);
        self.0.store(word << 16 | word, Ordering::Release);
    }
}

#[cfg(test)]
impl Position {
    /// Inverts a bit of the word.
    pub fn change(&self, bit: usize) {
        self.0.fetch_xor(1 << bit, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_changed_bit_of_each_position_shows() {
        for position in 0..=u16::MAX {
            let word = Position::new();
            word.set(position);
            assert_eq!(word.get(), Some(position));
            for bit in 0..32 {
                word.change(bit);
                assert_eq!(word.get(), None, "bit {bit} of {position}");
                word.change(bit);
            }
        }
    }
}
