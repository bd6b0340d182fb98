//! The AS5045 encoder at SPI1.

use rigless::chip::{Timeline, spi::Peer};
use rigless::snapshot::Store;

use crate::plant::SsiWord;

/// The encoder: latches the angle at the falling edge of CSn, and shifts it out.
#[derive(Debug, Default)]
pub struct EncoderChip {
    /// Word that is latched next.
    pub word: SsiWord,
    /// Number of selections.
    pub reads: u64,
    /// The feedback of the SPI's clock is late: the last bit of a frame is not captured, and keeps
    /// the value of the frame before (ES0206, corrupted last bit of data and CRC in master mode).
    pub is_clock_late: bool,
    latched: u32,
    clocked: u32,
    last: u32,
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
        if self.is_clock_late {
            out = out & !1 | self.last & 1;
        }
        self.last = out;
        out
    }

    fn select(&mut self, _: &mut Timeline<'_, '_>) {
        self.latched = self.word.bits();
        self.clocked = 0;
        self.reads += 1;
    }
}
