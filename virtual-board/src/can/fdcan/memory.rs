//! The message RAM: filters, received frames, frames to be transmitted (RM0433, chapter 56).

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rigless::device::{DeviceContext, ErasedDevice, RegisterFile, RequestChange};
use rigless::soc::{RegisterSpec, Width};
use rigless::time::{EventId, VirtualNanos};

use super::super::{Frame, Id};

/// Bytes of the message RAM.
pub const MESSAGE_RAM_BYTES: u64 = 10 << 10;

/// Bits of the first word of a frame.
const EXTENDED: u32 = 1 << 30;
const REMOTE: u32 = 1 << 29;

/// The message RAM, as the controller and the core share it.
#[derive(Debug, Clone)]
pub struct MessageRam {
    words: Arc<Mutex<Vec<u32>>>,
    layout: &'static [RegisterSpec],
}

impl MessageRam {
    /// Zeros; `layout` is that of its window on the bus.
    pub fn new(layout: &'static [RegisterSpec]) -> Self {
        Self {
            words: Arc::new(Mutex::new(vec![0; MESSAGE_RAM_BYTES as usize / 4])),
            layout,
        }
    }

    fn lock(&self) -> MutexGuard<'_, Vec<u32>> {
        self.words.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The word at an offset, bytes; zero behind the end.
    pub(super) fn word(&self, offset: u32) -> u32 {
        self.lock().get(offset as usize / 4).copied().unwrap_or(0)
    }

    /// Writes the word at an offset, bytes; none behind the end.
    pub(super) fn write(&self, offset: u32, value: u32) {
        if let Some(word) = self.lock().get_mut(offset as usize / 4) {
            *word = value;
        }
    }

    /// The frame of a transmit element.
    pub(super) fn frame(&self, offset: u32) -> Frame {
        let [head, control, low, high] = [0, 4, 8, 12].map(|word| self.word(offset + word));
        let data = u64::from(low) | u64::from(high) << 32;
        Frame {
            id: if head & EXTENDED != 0 {
                Id::Extended(head & 0x1fff_ffff)
            } else {
                Id::Standard((head >> 18) as u16 & 0x7ff)
            },
            remote: head & REMOTE != 0,
            dlc: (control >> 16 & 0xf) as u8,
            data: data.to_le_bytes(),
        }
    }

    /// Stores a received frame.
    pub(super) fn store(&self, offset: u32, frame: &Frame) {
        let id = match frame.id {
            Id::Standard(id) => u32::from(id) << 18,
            Id::Extended(id) => id | EXTENDED,
        };
        let data = u64::from_le_bytes(frame.data);
        let words = [
            id | if frame.remote { REMOTE } else { 0 },
            u32::from(frame.dlc) << 16,
            data as u32,
            (data >> 32) as u32,
        ];
        for (word, value) in (offset..).step_by(4).zip(words) {
            self.write(word, value);
        }
    }
}

impl ErasedDevice for MessageRam {
    fn layout(&self) -> &'static [RegisterSpec] {
        self.layout
    }

    fn read_window(&mut self, offset: u64, width: Width, _: &mut DeviceContext<'_>) -> u64 {
        let shift = 8 * (offset & 3);
        u64::from(self.word(offset as u32)) >> shift & width.mask()
    }

    fn write_window(
        &mut self,
        offset: u64,
        width: Width,
        value: u64,
        context: &mut DeviceContext<'_>,
    ) {
        if width != Width::W32 {
            context.tell("message RAM", "only words are written");
        }
        Self::write(self, offset as u32, value as u32);
    }

    fn peek_window(&self, offset: u64, _: Width, _: VirtualNanos) -> Option<u64> {
        Some(self.word(offset as u32).into())
    }

    fn reset(&mut self) {}

    // It has no registers, events, clocks or accesses.

    fn read(&mut self, _: usize, _: &mut RegisterFile, _: &mut DeviceContext<'_>) -> Option<u64> {
        None
    }

    fn write(&mut self, _: usize, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}

    fn on_event(&mut self, _: EventId, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}

    fn on_request(&mut self, _: RequestChange, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}

    fn on_clock(&mut self, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}

    fn poll(&mut self, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}

    fn on_access(&mut self, _: u64, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}

    fn on_refused(&mut self, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}
}
