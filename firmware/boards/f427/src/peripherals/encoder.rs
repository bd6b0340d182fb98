//! SPI1: the encoder is read by DMA.
//!
//! The clock runs at 656 kHz: half a period of 762 ns from CSn to its first edge and for each bit
//! to settle, 36.6 us for all bits.

use core::sync::atomic::{AtomicU8, Ordering::Relaxed};

use drivers::encoder::{BYTES, Transfer};
use stm32f4xx_hal::dma::StreamX;

use super::dma::{self, DmaStream};
use crate::chip::pac::{
    DMA2, SPI1,
    dma2::st::cr::{CIRC, DIR, PL},
};

static RECEIVED: [AtomicU8; BYTES] = [const { AtomicU8::new(0) }; BYTES];
/// The encoder has no data input; the clock runs while bytes are sent.
static SENT: [AtomicU8; BYTES] = [const { AtomicU8::new(0) }; BYTES];

/// SPI1 with its DMA streams. The interrupt of stream 0 signals the end of a transfer.
pub struct SpiTransfer {
    receive: DmaStream<0>,
    send: DmaStream<3>,
    spi: SPI1,
}

impl SpiTransfer {
    /// Sets SPI1 and its streams up, for [`drivers::encoder::MODE`].
    pub fn new(spi: SPI1, streams: (StreamX<DMA2, 0>, StreamX<DMA2, 3>)) -> Self {
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
        let transfer = |direction| dma::Transfer {
            channel: 3,
            direction,
            register: spi.dr().as_ptr() as u32,
            circular: CIRC::Disabled,
            priority: PL::High,
        };
        let mut receive = DmaStream::new(streams.0, &transfer(DIR::PeripheralToMemory), &RECEIVED);
        receive.listen();
        let send = DmaStream::new(streams.1, &transfer(DIR::MemoryToPeripheral), &SENT);
        Self { receive, send, spi }
    }
}

impl Transfer for SpiTransfer {
    #[inline]
    fn abort(&mut self) {
        self.receive.stop();
        self.send.stop();
        let _ = self.spi.dr().read();
        let _ = self.spi.sr().read();
    }

    #[inline]
    fn start(&mut self) {
        self.receive.start();
        self.send.start();
    }

    #[inline]
    fn end(&mut self) -> bool {
        self.receive.take_complete()
    }

    #[inline]
    fn bytes(&self) -> [u8; BYTES] {
        let [a, b, c] = &RECEIVED;
        [a, b, c].map(|byte| byte.load(Relaxed))
    }
}
