//! The AS5045 at the chip's serial interface.

use rigless::chip::{Timeline, spi::Peer};
use rigless::snapshot::Store;

use crate::plant::SsiWord;

/// The encoder: the angle is latched as its select falls, and shifted out from there.
#[derive(Debug, Default)]
pub(super) struct EncoderChip {
    /// What is latched next.
    pub word: SsiWord,
    /// Times that it was selected.
    pub reads: u64,
    latched: u32,
    clocked: u32,
}

impl Store for EncoderChip {}

impl Peer for EncoderChip {
    fn transfer(&mut self, _: u32, bits: u8, _: &mut Timeline<'_, '_>) -> u32 {
        let mut out = 0;
        for _ in 0..bits {
            let left = SsiWord::CLOCKS.checked_sub(self.clocked + 1);
            out = out << 1 | left.map_or(0, |left| self.latched >> left & 1);
            self.clocked += 1;
        }
        out
    }

    fn select(&mut self, _: &mut Timeline<'_, '_>) {
        self.latched = self.word.bits();
        self.clocked = 0;
        self.reads += 1;
    }
}
