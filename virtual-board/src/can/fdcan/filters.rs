//! Filters (RM0433, chapter 56): elements with two identifiers, or with an extended identifier and
//! a mask, which go to FIFO 0.

use super::super::{Frame, Id};
use super::memory::MessageRam;

/// Types of an element: two identifiers, or an identifier and its mask.
const PAIR: u32 = 0b01;
const MASK: u32 = 0b10;

/// Configuration that stores to FIFO 0.
const TO_FIFO_0: u32 = 0b001;

/// Position of the configuration in the word of a standard filter.
pub(super) const CONFIGURATION: u32 = 27;

/// The lists, as `SIDFC` and `XIDFC` have them.
pub(super) struct Filters {
    pub standard: u32,
    pub extended: u32,
}

impl Filters {
    /// Whether an element accepts this frame.
    pub fn accept(&self, ram: &MessageRam, frame: &Frame) -> bool {
        match frame.id {
            Id::Standard(id) => {
                let (start, count) = list(self.standard, 0xff);
                (0..count).any(|element| {
                    let word = ram.word(start + 4 * element);
                    let ids = [word >> 16 & 0x7ff, word & 0x7ff];
                    word >> 30 == PAIR
                        && word >> CONFIGURATION & 0b111 == TO_FIFO_0
                        && ids.contains(&u32::from(id))
                })
            }
            Id::Extended(id) => {
                let (start, count) = list(self.extended, 0x7f);
                (0..count).any(|element| {
                    let [first, second] = [0, 4].map(|word| ram.word(start + 8 * element + word));
                    let ids = [first & 0x1fff_ffff, second & 0x1fff_ffff];
                    let is_accepted = match second >> 30 {
                        PAIR => ids.contains(&id),
                        MASK => (ids[0] ^ id) & ids[1] == 0,
                        _ => false,
                    };
                    first >> 29 == TO_FIFO_0 && is_accepted
                })
            }
        }
    }
}

/// Offset, bytes, and number of elements of a list.
pub(super) fn list(register: u32, count: u32) -> (u32, u32) {
    (register & 0xfffc, register >> 16 & count)
}
