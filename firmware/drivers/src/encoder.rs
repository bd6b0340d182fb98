//! The AS5045 encoder at an SPI bus.
//!
//! The encoder latches its angle at the first falling edge of the clock after CSn falls, 0.8 us
//! later (data sheet, section 8.1 and table 14). It shifts its first bit out at the first *rising*
//! edge, at most 413 ns after it, and each further bit at the next one. The clock idles high, so
//! that the first edge is a falling one. Sampling at falling edges, [`MODE`], gives each bit half a
//! period to settle; the first edge samples no data bit:
//!
//! ```text
//! CSn  \___________________________________________/
//! CLK  ----\_/-\_/-\_/-\_ ... 24 periods
//! DO   ~~------<D11<D10<D9   ... parity, then zeros
//!          ^   ^   ^   ^     sampled: dummy, D11, D10, ...
//! ```

use embedded_hal::{
    digital::OutputPin,
    spi::{MODE_2, Mode},
};
use model_core::control::encoder_word::EncoderWord;

/// Bytes of a transfer.
pub const BYTES: usize = 3;

/// Polarity and phase of the clock.
pub const MODE: Mode = MODE_2;

/// Highest frequency of the clock, Hz (data sheet, table 14).
pub const MAX_CLOCK_HZ: u32 = 1_000_000;

/// Time from CSn to the first edge of the clock, ns, at least (data sheet, table 14).
pub const SELECT_NS: u32 = 500;

/// Bits after the word: of 24, one precedes it and 18 belong to it.
const TRAILING_BITS: u32 = 8 * BYTES as u32 - 1 - 18;

/// A transfer of [`BYTES`] bytes that the hardware carries out, and at whose end it interrupts.
pub trait Transfer {
    /// Aborts a transfer, and discards what was received.
    fn abort(&mut self);

    /// Starts a transfer. The first edge of the clock has to follow after [`SELECT_NS`].
    fn start(&mut self);

    /// Whether a transfer has ended since the last call.
    fn end(&mut self) -> bool;

    /// The bytes of the last transfer that has ended.
    fn bytes(&self) -> [u8; BYTES];
}

/// The encoder, with its transfer and its chip select.
#[derive(Debug)]
pub struct As5045<T, P> {
    transfer: T,
    /// CSn, active low.
    select: P,
    is_read: bool,
}

impl<T: Transfer, P: OutputPin> As5045<T, P> {
    /// The encoder that this transfer reads while this pin selects it.
    pub const fn new(transfer: T, select: P) -> Self {
        Self {
            transfer,
            select,
            is_read: false,
        }
    }

    /// Latches the angle and starts to read it.
    #[inline]
    pub fn start(&mut self) {
        // An aborted transfer leaves data behind, which would shift the next word.
        self.transfer.abort();
        // A pin that fails leaves the encoder deselected: it then reads as zeros, which is invalid.
        let _ = self.select.set_low();
        self.transfer.start();
    }

    /// Ends the reading. The word that was read; `None` if the transfer is incomplete.
    #[inline]
    pub fn finish(&mut self) -> Option<EncoderWord> {
        let _ = self.select.set_high();
        self.is_read = self.transfer.end();
        self.word()
    }

    /// The word of the last [`As5045::finish`], from the bytes of the transfer.
    #[inline]
    pub fn word(&self) -> Option<EncoderWord> {
        if !self.is_read {
            return None;
        }
        let [a, b, c] = self.transfer.bytes();
        let bits = u32::from_be_bytes([0, a, b, c]) >> TRAILING_BITS;
        Some(EncoderWord::new(bits))
    }
}

#[cfg(test)]
mod tests {
    use core::convert::Infallible;

    use embedded_hal::digital::ErrorType;
    use model_core::control::encoder_word::{EncoderCount, Magnet};

    use super::*;

    /// A transfer that has received these bytes, and a pin that nothing observes.
    struct Received([u8; BYTES]);

    impl Transfer for Received {
        fn abort(&mut self) {}

        fn start(&mut self) {}

        fn end(&mut self) -> bool {
            true
        }

        fn bytes(&self) -> [u8; BYTES] {
            self.0
        }
    }

    struct Pin;

    impl ErrorType for Pin {
        type Error = Infallible;
    }

    impl OutputPin for Pin {
        fn set_low(&mut self) -> Result<(), Infallible> {
            Ok(())
        }

        fn set_high(&mut self) -> Result<(), Infallible> {
            Ok(())
        }
    }

    /// The last bit of each byte may be that of an earlier one (ES0206, corrupted last bit of data
    /// in master mode with delayed SCK feedback). These are D5, LIN, which a valid word has clear,
    /// and one behind the word: a wrong D5 alone has odd parity, and with LIN it is an alarm.
    #[test]
    fn stale_last_bits_of_the_bytes_never_give_another_angle() {
        let magnets = [
            Magnet::Steady,
            Magnet::Approaching,
            Magnet::Receding,
            Magnet::Marginal,
        ];
        for (count, magnet) in (0..4096).flat_map(|count| magnets.map(|magnet| (count, magnet))) {
            let word = EncoderWord::of(EncoderCount::new(count), magnet);
            let [_, a, b, c] = (word.bits() << TRAILING_BITS).to_be_bytes();
            for stale in 0..8_u8 {
                let last = |byte: u8, number: u32| byte & !1 | stale >> number & 1;
                let bytes = [last(a, 0), last(b, 1), last(c, 2)];
                let read = As5045::new(Received(bytes), Pin)
                    .finish()
                    .map(EncoderWord::read);
                let is_same = read.is_some_and(|read| {
                    read.is_err() || read.is_ok_and(|reading| reading.count.get() == count)
                });
                assert!(is_same, "{count} with {stale:03b}: {read:?}");
            }
        }
    }
}
