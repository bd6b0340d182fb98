//! The servo bus: USART1 with one wire, half duplex, and its FIFOs (RM0433, chapter 48).
//!
//! A FIFO of 16 bytes bridges the tasks of the loop, which delay this one by less than 30 us. A
//! pause of one byte ends what is received. The receiver is off while an answer is transmitted: it
//! would hear it.

use cortex_m::singleton;

use super::timing::APB2_HZ;
use crate::{
    actuator::{line_timer::LineTimer, servo_bus_task::LineEvent},
    chip::pac::{TIM5, USART1},
};

/// Bytes of the longest packet, and of the longest answer.
const BYTES: usize = 1024;

/// Thresholds of the FIFOs (section 48.8.4): the receiver's interrupts from 4 bytes on, 40 us
/// before it is full at 3 Mbit/s; the transmitter's when 8 are left.
const QUARTER: u8 = 0b001;
const HALF: u8 = 0b010;

/// The line and its timer.
pub struct ServoLine {
    usart: USART1,
    /// Bytes that were received, or that are to be transmitted.
    bytes: &'static mut [u8],
    length: usize,
    /// Bytes of the answer that the FIFO has taken.
    sent: usize,
    is_transmitting: bool,
    pub timer: LineTimer,
}

impl ServoLine {
    /// The line, off.
    pub fn new(usart: USART1, timer: TIM5) -> Self {
        Self {
            usart,
            // Not moved with the peripherals over the stack.
            bytes: singleton!(: [u8; BYTES] = [0; BYTES]).map_or(&mut [], |bytes| bytes),
            length: 0,
            sent: 0,
            is_transmitting: false,
            timer: LineTimer::new(timer),
        }
    }

    /// Turns the line on, at this bit rate.
    pub fn start(&mut self, bit_s: u32) {
        self.set_bit_rate(bit_s);
        self.receive();
    }

    /// Sets the bit rate, bit/s, which takes a USART that is off for a moment.
    pub fn set_bit_rate(&mut self, bit_s: u32) {
        // Rounded; of 84 MHz the error is below 0.1 % up to 4 Mbit/s.
        let divider = (APB2_HZ + bit_s / 2) / bit_s.max(1);
        if self.usart.brr().read().bits() != divider {
            self.usart.cr1().modify(|_, w| w.ue().disabled());
            // SAFETY: the divider with 16 samples for each bit.
            self.usart.brr().write(|w| unsafe { w.bits(divider) });
            self.receive();
        }
    }

    /// Receives.
    pub fn receive(&mut self) {
        (self.length, self.is_transmitting) = (0, false);
        // SAFETY: thresholds of section 48.8.4.
        self.usart.cr3().write(|w| unsafe {
            w.hdsel().set_bit();
            w.rxftcfg().bits(QUARTER).rxftie().set_bit();
            w.txftcfg().bits(HALF)
        });
        self.usart.cr1().write(|w| {
            w.fifoen().set_bit().ue().enabled();
            w.te().enabled().re().enabled().idleie().enabled()
        });
    }

    /// Whether bytes are received, without a pause until now.
    pub fn is_receiving(&self) -> bool {
        self.length > 0 || self.usart.isr().read().rxne().bit()
    }

    /// Transmits what `write` puts into a buffer, of which it returns the length.
    pub fn transmit(&mut self, write: impl FnOnce(&mut [u8]) -> usize) {
        self.length = write(self.bytes);
        (self.sent, self.is_transmitting) = (0, true);
        self.usart.icr().write(|w| w.tccf().clear_bit_by_one());
        self.usart.cr1().write(|w| {
            w.fifoen().set_bit().ue().enabled().te().enabled();
            w.tcie().enabled()
        });
        self.fill();
        self.usart
            .cr3()
            .modify(|_, w| w.rxftie().clear_bit().txftie().set_bit());
    }

    /// Moves bytes of the answer to the FIFO, as far as it has room.
    fn fill(&mut self) {
        while self.usart.isr().read().txe().bit()
            && let Some(byte) = self
                .bytes
                .get(self.sent)
                .filter(|_| self.sent < self.length)
        {
            self.usart.tdr().write(|w| w.tdr().set((*byte).into()));
            self.sent += 1;
        }
        if self.sent >= self.length {
            self.usart.cr3().modify(|_, w| w.txftie().clear_bit());
        }
    }

    /// What has happened since the last call.
    pub fn take_event(&mut self) -> LineEvent<'_> {
        if self.is_transmitting {
            self.fill();
            let has_ended = self.sent >= self.length && self.usart.isr().read().tc().bit();
            if !has_ended {
                return LineEvent::None;
            }
            self.is_transmitting = false;
            return LineEvent::Transmitted;
        }
        // Before the bytes: those behind this pause have another one behind them.
        let is_idle = self.usart.isr().read().idle().bit();
        if is_idle {
            self.usart.icr().write(|w| w.idlecf().clear_bit_by_one());
        }
        while self.usart.isr().read().rxne().bit() {
            let byte = self.usart.rdr().read().rdr().bits() as u8;
            if let Some(place) = self.bytes.get_mut(self.length) {
                *place = byte;
                self.length += 1;
            }
        }
        self.usart.icr().write(|w| {
            w.orecf()
                .clear_bit_by_one()
                .fecf()
                .clear_bit_by_one()
                .ncf()
                .clear_bit_by_one()
        });
        if !is_idle {
            return LineEvent::None;
        }
        let length = core::mem::take(&mut self.length);
        LineEvent::Received(self.bytes.get(..length).unwrap_or_default())
    }
}
