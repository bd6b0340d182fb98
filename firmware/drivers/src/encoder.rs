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
    spi::{MODE_2, Mode, Operation, SpiDevice},
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

/// A bus that reads the encoder.
pub trait Bus {
    /// Selects the encoder, which latches its angle, and starts to read it; a bus that blocks reads
    /// all of it.
    fn begin(&mut self);

    /// Releases the encoder. Whether all bytes have been read since `begin`.
    fn end(&mut self) -> bool;

    /// The bytes of the last transfer that has ended.
    fn bytes(&self) -> [u8; BYTES];
}

/// The encoder.
#[derive(Debug)]
pub struct As5045<B> {
    bus: B,
    is_read: bool,
}

impl<B: Bus> As5045<B> {
    /// The encoder at this bus.
    pub const fn new(bus: B) -> Self {
        Self {
            bus,
            is_read: false,
        }
    }

    /// Latches the angle and starts to read it.
    #[inline]
    pub fn start(&mut self) {
        self.bus.begin();
    }

    /// Ends the reading. The word that was read; `None` if the transfer is incomplete.
    #[inline]
    pub fn finish(&mut self) -> Option<EncoderWord> {
        self.is_read = self.bus.end();
        self.word()
    }

    /// The word of the last [`As5045::finish`], from the bytes of the transfer.
    #[inline]
    pub fn word(&self) -> Option<EncoderWord> {
        if !self.is_read {
            return None;
        }
        let [a, b, c] = self.bus.bytes();
        let bits = u32::from_be_bytes([0, a, b, c]) >> TRAILING_BITS;
        Some(EncoderWord::new(bits))
    }

    /// The bus.
    pub fn release(self) -> B {
        self.bus
    }
}

/// A bus that blocks for the transfer: any `SpiDevice` of [`MODE`] with at most [`MAX_CLOCK_HZ`].
///
/// ```
/// use drivers::encoder::{As5045, Blocking, SELECT_NS};
/// use embedded_hal_mock::eh1::spi::{Mock, Transaction};
///
/// let device = Mock::new(&[
///     Transaction::transaction_start(),
///     Transaction::delay(SELECT_NS),
///     Transaction::read_vec(vec![0x40, 0x04, 0x00]),
///     Transaction::transaction_end(),
/// ]);
/// let mut encoder = As5045::new(Blocking::new(device));
/// encoder.start();
/// let word = encoder.finish().expect("the transfer is complete");
/// assert_eq!(word.read().expect("its parity is even").count.get(), 2048);
/// assert_eq!(encoder.finish(), None);
/// encoder.release().release().done();
/// ```
#[derive(Debug)]
pub struct Blocking<S> {
    device: S,
    received: [u8; BYTES],
    is_new: bool,
}

impl<S: SpiDevice> Blocking<S> {
    /// A bus of this device.
    pub const fn new(device: S) -> Self {
        Self {
            device,
            received: [0; BYTES],
            is_new: false,
        }
    }

    /// The device.
    pub fn release(self) -> S {
        self.device
    }
}

impl<S: SpiDevice> Bus for Blocking<S> {
    fn begin(&mut self) {
        let mut bytes = [0; BYTES];
        let mut operations = [
            Operation::DelayNs(SELECT_NS),
            Operation::Read(bytes.as_mut_slice()),
        ];
        self.is_new = self.device.transaction(&mut operations).is_ok();
        self.received = bytes;
    }

    fn end(&mut self) -> bool {
        core::mem::take(&mut self.is_new)
    }

    fn bytes(&self) -> [u8; BYTES] {
        self.received
    }
}

/// A transfer of [`BYTES`] bytes that the hardware carries out, and at whose end it interrupts.
pub trait Transfer {
    /// Aborts a transfer, and discards what was received.
    fn abort(&mut self);

    /// Starts a transfer.
    fn start(&mut self);

    /// Whether a transfer has ended since the last call.
    fn end(&mut self) -> bool;

    /// The bytes of the last transfer that has ended.
    fn bytes(&self) -> [u8; BYTES];
}

/// A bus with exact instants: the encoder latches its angle when [`Bus::begin`] is called, and the
/// transfer does not occupy the processor.
#[derive(Debug)]
pub struct Timed<T, P> {
    transfer: T,
    /// CSn, active low.
    select: P,
}

impl<T: Transfer, P: OutputPin> Timed<T, P> {
    /// A bus of this transfer, with this pin as CSn. The first edge of the clock has to follow
    /// [`SELECT_NS`] after the start of the transfer.
    pub const fn new(transfer: T, select: P) -> Self {
        Self { transfer, select }
    }

    /// The transfer and the pin.
    pub fn release(self) -> (T, P) {
        (self.transfer, self.select)
    }
}

impl<T: Transfer, P: OutputPin> Bus for Timed<T, P> {
    #[inline]
    fn begin(&mut self) {
        // An aborted transfer leaves data behind, which would shift the next word.
        self.transfer.abort();
        // A pin that fails leaves the encoder deselected: it then reads as zeros, which is invalid.
        let _ = self.select.set_low();
        self.transfer.start();
    }

    #[inline]
    fn end(&mut self) -> bool {
        let _ = self.select.set_high();
        self.transfer.end()
    }

    #[inline]
    fn bytes(&self) -> [u8; BYTES] {
        self.transfer.bytes()
    }
}

#[cfg(test)]
mod tests {
    use model_core::control::encoder_word::{EncoderCount, Magnet};

    use super::*;

    /// A bus that has received these bytes.
    struct Received([u8; BYTES]);

    impl Bus for Received {
        fn begin(&mut self) {}

        fn end(&mut self) -> bool {
            true
        }

        fn bytes(&self) -> [u8; BYTES] {
            self.0
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
                let read = As5045::new(Received(bytes)).finish().map(EncoderWord::read);
                let is_same = read.is_some_and(|read| {
                    read.is_err() || read.is_ok_and(|reading| reading.count.get() == count)
                });
                assert!(is_same, "{count} with {stale:03b}: {read:?}");
            }
        }
    }
}
