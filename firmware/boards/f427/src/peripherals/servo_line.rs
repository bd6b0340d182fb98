//! The servo bus: USART1 with one wire, half duplex (RM0090, chapter 30), and its streams of DMA2.
//!
//! The stream of the receiver writes a ring of bytes, as the tasks of the loop delay this one for
//! longer than a byte takes. A pause of one byte ends what is received. The receiver is off while
//! an answer is transmitted: it would hear it.

use core::sync::atomic::{AtomicU8, Ordering::Relaxed};

use cortex_m::singleton;
use stm32f4xx_hal::dma::StreamX;

use super::{
    dma::{self, DmaStream},
    timing::APB2_HZ,
};
use crate::{
    actuator::{line_timer::LineTimer, servo_bus_task::LineEvent},
    chip::pac::{
        DMA2, TIM5, USART1,
        dma2::st::cr::{CIRC, DIR, PL},
    },
};

/// Bytes of the ring, more than the longest packet, and of the longest answer.
const BYTES: usize = 1024;

static RECEIVED: [AtomicU8; BYTES] = [const { AtomicU8::new(0) }; BYTES];
static SENT: [AtomicU8; BYTES] = [const { AtomicU8::new(0) }; BYTES];

/// The line and its timer.
pub struct ServoLine {
    usart: USART1,
    receiver: DmaStream<5>,
    sender: DmaStream<7>,
    /// The place in the ring behind the bytes that were taken.
    taken: usize,
    bytes: &'static mut [u8],
    pub timer: LineTimer,
}

impl ServoLine {
    /// The line, off.
    pub fn new(usart: USART1, streams: (StreamX<DMA2, 5>, StreamX<DMA2, 7>), timer: TIM5) -> Self {
        let transfer = |direction, circular| dma::Transfer {
            channel: 4,
            direction,
            register: usart.dr().as_ptr() as u32,
            circular,
            priority: PL::Low,
        };
        let received = transfer(DIR::PeripheralToMemory, CIRC::Enabled);
        let sent = transfer(DIR::MemoryToPeripheral, CIRC::Disabled);
        Self {
            receiver: DmaStream::new(streams.0, &received, &RECEIVED),
            sender: DmaStream::new(streams.1, &sent, &SENT),
            usart,
            taken: 0,
            // Not moved with the peripherals over the stack.
            bytes: singleton!(: [u8; BYTES] = [0; BYTES]).map_or(&mut [], |bytes| bytes),
            timer: LineTimer::new(timer),
        }
    }

    /// Turns the line on, at this bit rate.
    pub fn start(&mut self, bit_s: u32) {
        self.usart
            .cr3()
            .write(|w| w.hdsel().half_duplex().dmar().enabled().dmat().enabled());
        self.set_bit_rate(bit_s);
        self.receiver.start();
        self.receive();
    }

    /// Sets the bit rate, bit/s.
    pub fn set_bit_rate(&mut self, bit_s: u32) {
        // Rounded; of 84 MHz the error is below 0.1 % up to 4 Mbit/s.
        let divider = ((APB2_HZ + bit_s / 2) / bit_s.max(1)) as u16;
        if self.usart.brr().read().bits() != divider {
            // SAFETY: mantissa and fraction side by side, as with 16 samples for each bit.
            self.usart.brr().write(|w| unsafe { w.bits(divider) });
        }
    }

    /// Receives.
    pub fn receive(&mut self) {
        self.usart.cr1().write(|w| {
            w.ue().enabled().te().enabled().re().enabled();
            w.idleie().enabled()
        });
    }

    /// Whether bytes are received, without a pause until now.
    pub fn is_receiving(&self) -> bool {
        self.end() != self.taken
    }

    /// The place in the ring behind the bytes that were received.
    fn end(&self) -> usize {
        (BYTES - usize::from(self.receiver.left()).min(BYTES)) % BYTES
    }

    /// Transmits what `write` puts into a buffer, of which it returns the length.
    pub fn transmit(&mut self, write: impl FnOnce(&mut [u8]) -> usize) {
        let length = write(self.bytes);
        for (place, byte) in SENT.iter().zip(self.bytes.iter().take(length)) {
            place.store(*byte, Relaxed);
        }
        self.usart.cr1().write(|w| w.ue().enabled().te().enabled());
        self.usart.sr().write(|w| w.tc().clear_bit());
        self.sender.start_with(length as u16);
        self.usart.cr1().modify(|_, w| w.tcie().enabled());
    }

    /// What has happened since the last call.
    pub fn take_event(&mut self) -> LineEvent<'_> {
        let status = self.usart.sr().read();
        let control = self.usart.cr1().read();
        if control.tcie().bit() {
            if !status.tc().bit() {
                return LineEvent::None;
            }
            self.usart.cr1().modify(|_, w| w.tcie().disabled());
            return LineEvent::Transmitted;
        }
        if !status.idle().bit() {
            return LineEvent::None;
        }
        // Behind the read of the status, this clears its flags. The stream has taken the bytes
        // before the pause; one that arrives in this instant may be lost, with its packet.
        let _ = self.usart.dr().read();
        let (end, mut length) = (self.end(), 0);
        while self.taken != end {
            let byte = RECEIVED
                .get(self.taken)
                .map_or(0, |byte| byte.load(Relaxed));
            if let Some(place) = self.bytes.get_mut(length) {
                *place = byte;
            }
            (length, self.taken) = (length + 1, (self.taken + 1) % BYTES);
        }
        LineEvent::Received(self.bytes.get(..length).unwrap_or_default())
    }
}
