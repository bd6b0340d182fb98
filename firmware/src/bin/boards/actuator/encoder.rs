//! The AS5045 encoder at SPI1, read by DMA.
//!
//! The encoder latches its angle at the first falling edge of the clock after CSn falls, 0.8 us
//! later (data sheet, section 8.1 and table 14). It shifts its first bit out at the first *rising*
//! edge, at most 413 ns after it, and each further bit at the next one. The clock idles high, so
//! that the first edge is a falling one. Sampling at falling edges (CPOL = 1, CPHA = 0) gives each
//! bit half a period of 762 ns to settle, and the same time between CSn and the first edge, of
//! which 500 ns are required. The first edge samples no data bit:
//!
//! ```text
//! CSn  \___________________________________________/
//! CLK  ----\_/-\_/-\_/-\_ ... 24 periods of 656 kHz, 36.6 us
//! DO   ~~------<D11<D10<D9   ... parity, then zeros
//!          ^   ^   ^   ^     sampled: dummy, D11, D10, ...
//! ```

use core::sync::atomic::{AtomicU8, Ordering::Relaxed};

use model_core::control::encoder_word::EncoderWord;
use stm32f4xx_hal::{
    dma::StreamX,
    pac::{
        DMA2, GPIOA, SPI1,
        dma2::st::cr::{CIRC, DIR, PL},
    },
};

use super::{
    dma::{DmaStream, Transfer},
    pins::ENCODER_SELECT,
};

static RECEIVED: [AtomicU8; 3] = [const { AtomicU8::new(0) }; 3];
/// The encoder has no data input; the clock runs while bytes are sent.
static SENT: [AtomicU8; 3] = [const { AtomicU8::new(0) }; 3];

/// Bits after the word: of 24, one precedes it and 18 belong to it.
const TRAILING_BITS: u32 = 24 - 1 - 18;

/// The encoder and its DMA streams.
pub struct Encoder {
    /// The port of CSn, which is active low.
    port: GPIOA,
    receive: DmaStream<0>,
    send: DmaStream<3>,
    spi: SPI1,
}

impl Encoder {
    /// Sets SPI1 and its streams up.
    pub fn new(spi: SPI1, port: GPIOA, streams: (StreamX<DMA2, 0>, StreamX<DMA2, 3>)) -> Self {
        spi.cr2()
            .write(|w| w.rxdmaen().enabled().txdmaen().enabled());
        // 84 MHz / 128 = 656 kHz; a master that does not control CSn.
        spi.cr1().write(|w| {
            w.mstr()
                .master()
                .br()
                .div128()
                .cpol()
                .idle_high()
                .cpha()
                .first_edge();
            w.ssm().enabled().ssi().slave_not_selected().spe().enabled()
        });
        let transfer = |direction| Transfer {
            channel: 3,
            direction,
            register: spi.dr().as_ptr() as u32,
            circular: CIRC::Disabled,
            priority: PL::High,
        };
        let mut receive = DmaStream::new(streams.0, &transfer(DIR::PeripheralToMemory), &RECEIVED);
        receive.listen();
        let send = DmaStream::new(streams.1, &transfer(DIR::MemoryToPeripheral), &SENT);
        Self {
            port,
            receive,
            send,
            spi,
        }
    }

    fn select(&self, is_selected: bool) {
        let bit = ENCODER_SELECT + if is_selected { 16 } else { 0 };
        // SAFETY: one bit sets or resets one pin.
        self.port.bsrr().write(|w| unsafe { w.bits(1 << bit) });
    }

    /// Latches the angle and starts to read it; the interrupt of stream 0 signals the end.
    pub fn start(&mut self) {
        self.receive.stop();
        self.send.stop();
        // An aborted transfer leaves data in the registers, which would shift the next word.
        let _ = self.spi.dr().read();
        let _ = self.spi.sr().read();
        self.select(true);
        self.receive.start();
        self.send.start();
    }

    /// The word that was read; `None` if the transfer is incomplete.
    pub fn finish(&mut self) -> Option<EncoderWord> {
        self.select(false);
        if !self.receive.take_complete() {
            return None;
        }
        let [a, b, c] = &RECEIVED;
        let [a, b, c] = [a, b, c].map(|byte| byte.load(Relaxed));
        let bits = u32::from_be_bytes([0, a, b, c]) >> TRAILING_BITS;
        Some(EncoderWord::new(bits))
    }
}
