//! SPI1: a transfer of three bytes fits the FIFOs, and needs no DMA.
//!
//! The clock runs at 656 kHz: half a period of 762 ns from CSn to its first edge and for each bit
//! to settle, 36.6 us for all bits.

use drivers::encoder::{BYTES, Transfer};

use crate::chip::pac::SPI1;

/// SPI1, which interrupts at the end of a transfer.
pub struct SpiTransfer {
    spi: SPI1,
    /// What the last transfer has received.
    bytes: [u8; BYTES],
}

impl SpiTransfer {
    /// Sets SPI1 up, for [`drivers::encoder::MODE`].
    pub fn new(spi: SPI1) -> Self {
        // 42 MHz / 64 = 656 kHz; frames of one byte.
        spi.cfg1()
            .write(|w| w.mbr().div64().dsize().set(8 - 1).fthlv().one_frame());
        // A master that does not control CSn, and holds its outputs while it is disabled.
        spi.cr1().write(|w| w.ssi().slave_not_selected());
        spi.cfg2().write(|w| {
            w.master().master().ssm().enabled().afcntr().controlled();
            w.cpol().idle_high().cpha().first_edge()
        });
        // With a length, TXC is a copy of EOT; without one it interrupts at once (ES0392, item
        // 2.22.4).
        spi.cr2().write(|w| w.tsize().set(BYTES as u16));
        spi.ier().write(|w| w.eotie().set_bit());
        Self {
            spi,
            bytes: [0; BYTES],
        }
    }
}

impl Transfer for SpiTransfer {
    /// Disabling SPI1 empties its FIFOs (RM0433, section 50.4.12).
    #[inline]
    fn abort(&mut self) {
        self.spi.cr1().modify(|_, w| w.spe().disabled());
        self.spi
            .ifcr()
            .write(|w| w.eotc().clear().txtfc().clear().ovrc().clear());
    }

    #[inline]
    fn start(&mut self) {
        self.spi.cr1().modify(|_, w| w.spe().enabled());
        // The encoder has no data input; the clock runs while bytes are sent.
        for _ in 0..BYTES {
            self.send_zero();
        }
        self.spi.cr1().modify(|_, w| w.cstart().set_bit());
    }

    #[inline]
    fn end(&mut self) -> bool {
        let has_ended = self.spi.sr().read().eot().bit();
        if has_ended {
            self.bytes = [self.receive(), self.receive(), self.receive()];
            self.abort();
        }
        has_ended
    }

    #[inline]
    fn bytes(&self) -> [u8; BYTES] {
        self.bytes
    }
}

#[allow(
    clippy::cast_ptr_alignment,
    reason = "the width of an access to a data register is the number of bytes that it moves"
)]
impl SpiTransfer {
    /// Sends a byte of zeros.
    #[inline]
    fn send_zero(&self) {
        let register = self.spi.txdr().as_ptr().cast::<u8>();
        // SAFETY: the address of the data register, which takes bytes (section 50.4.13).
        unsafe { register.write_volatile(0) };
    }

    /// Takes a received byte.
    #[inline]
    fn receive(&self) -> u8 {
        let register = self.spi.rxdr().as_ptr().cast::<u8>();
        // SAFETY: as above.
        unsafe { register.read_volatile() }
    }
}
