//! The message RAM of FDCAN1: its layout, and frames and filters as words (RM0433, chapter 56).

use canopen::CanFrame;
use embedded_can::{ExtendedId, Frame as _, Id, StandardId};

/// Address of its first word.
const BASE: usize = 0x4000_ac00;

/// Elements of each list. Two identifiers share a filter element.
pub const FILTERS: u16 = 14;
pub const RECEIVED: u16 = 32;

/// Words of an element for a frame of eight bytes.
const FRAME_WORDS: u16 = 4;

/// Offsets of the lists, words: filters of standard and of extended identifiers, received frames,
/// the frame to be transmitted.
pub const STANDARD_FILTERS: u16 = 0;
pub const EXTENDED_FILTERS: u16 = STANDARD_FILTERS + FILTERS;
pub const RECEIVE_FIFO: u16 = EXTENDED_FILTERS + 2 * FILTERS;
pub const TRANSMIT: u16 = RECEIVE_FIFO + FRAME_WORDS * RECEIVED;
const END: u16 = TRANSMIT + FRAME_WORDS;

/// Bits of the first word of a frame.
const EXTENDED: u32 = 1 << 30;
const REMOTE: u32 = 1 << 29;

/// Position of a base identifier in it.
const BASE_ID: u32 = 18;

/// Position of the length in the second word.
const LENGTH: u32 = 16;

/// Codes of filter elements: two identifiers, or one and its mask, to FIFO 0.
const STANDARD_PAIR: u32 = 0b01 << 30 | 0b001 << 27;
const EXTENDED_TO_FIFO: u32 = 0b001 << 29;
const EXTENDED_PAIR: u32 = 0b01 << 30;
const EXTENDED_WITH_MASK: u32 = 0b10 << 30;

/// A word of the message RAM; one behind its end is its last one.
fn word(offset: u16) -> *mut u32 {
    let offset = usize::from(offset.min(END - 1));
    core::ptr::with_exposed_provenance_mut(BASE + 4 * offset)
}

fn read(offset: u16) -> u32 {
    // SAFETY: a word of the message RAM, whose clock is enabled.
    unsafe { word(offset).read_volatile() }
}

fn write(offset: u16, value: u32) {
    // SAFETY: as above; any content is a frame or a filter.
    unsafe { word(offset).write_volatile(value) };
}

/// The received frame of this index.
pub fn received(index: u8) -> CanFrame {
    let element = RECEIVE_FIFO + FRAME_WORDS * u16::from(index);
    let [head, length, low, high] = [0, 1, 2, 3].map(|word| read(element + word));
    let id = if head & EXTENDED != 0 {
        Id::Extended(ExtendedId::new(head & 0x1fff_ffff).unwrap_or(ExtendedId::ZERO))
    } else {
        let base = (head >> BASE_ID) as u16 & 0x7ff;
        Id::Standard(StandardId::new(base).unwrap_or(StandardId::ZERO))
    };
    let [a, b, c, d] = low.to_le_bytes();
    let [e, f, g, h] = high.to_le_bytes();
    let length = (length >> LENGTH & 0xf) as u8;
    CanFrame::received(id, head & REMOTE != 0, length, [a, b, c, d, e, f, g, h])
}

/// Writes the frame to be transmitted.
pub fn set_transmitted(frame: &CanFrame) {
    let id = match frame.id() {
        Id::Standard(id) => u32::from(id.as_raw()) << BASE_ID,
        Id::Extended(id) => id.as_raw() | EXTENDED,
    };
    let remote = if frame.is_remote_frame() { REMOTE } else { 0 };
    let [a, b, c, d, e, f, g, h] = frame.bytes();
    let words = [
        id | remote,
        (frame.dlc() as u32) << LENGTH,
        u32::from_le_bytes([a, b, c, d]),
        u32::from_le_bytes([e, f, g, h]),
    ];
    for (offset, value) in (TRANSMIT..).zip(words) {
        write(offset, value);
    }
}

/// Sets the filter elements to these identifiers, of which every other one may be the mask of the
/// extended one before; the remaining elements are off.
pub fn set_filters(identifiers: impl Iterator<Item = Id> + Clone, has_masks: bool) {
    let kind = if has_masks {
        EXTENDED_WITH_MASK
    } else {
        EXTENDED_PAIR
    };
    let mut standard = identifiers.clone().filter_map(|id| match id {
        Id::Standard(id) => Some(u32::from(id.as_raw())),
        Id::Extended(_) => None,
    });
    let mut extended = identifiers.filter_map(|id| match id {
        Id::Extended(id) => Some(id.as_raw()),
        Id::Standard(_) => None,
    });
    for element in 0..FILTERS {
        let pair = next_pair(&mut standard);
        let value = pair.map_or(0, |(first, second)| STANDARD_PAIR | first << 16 | second);
        write(STANDARD_FILTERS + element, value);
        let pair = next_pair(&mut extended);
        let (first, second) = pair.map_or((0, 0), |(first, second)| {
            (EXTENDED_TO_FIFO | first, kind | second)
        });
        write(EXTENDED_FILTERS + 2 * element, first);
        write(EXTENDED_FILTERS + 2 * element + 1, second);
    }
}

/// The next two, or the last one twice.
fn next_pair(identifiers: &mut impl Iterator<Item = u32>) -> Option<(u32, u32)> {
    let first = identifiers.next()?;
    Some((first, identifiers.next().unwrap_or(first)))
}
