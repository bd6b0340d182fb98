//! The serial line: USART3, one byte at a time, between the line and two queues.
//!
//! A byte that is lost or damaged is replaced by one that no command contains: its line is refused,
//! and is never executed as another command.

use heapless::spsc::{Consumer, Producer};
use stm32f4xx_hal::pac::USART3;

use super::pins::BAUD;

/// Clock of the USART, Hz: that of APB1.
const CLOCK_HZ: u32 = 40_000_000;
const _: () = assert!(CLOCK_HZ.is_multiple_of(BAUD), "the speed is exact");

/// Baud rate divider, with 8 data bits, no parity, one stop bit.
const CYCLES_PER_BIT: u16 = (CLOCK_HZ / BAUD) as u16;

/// Length of the queue of received bytes: 5 ms of the line.
pub const RECEIVE_QUEUE: usize = 1024;

/// Length of the queue of bytes to be transmitted: 5 ms of the line.
pub const TRANSMIT_QUEUE: usize = 1024;

/// Byte that makes a command invalid.
const DAMAGED: u8 = 0xff;

/// Received bytes after which the adapter runs even without the end of a command.
const RECEIVE_THRESHOLD: usize = RECEIVE_QUEUE / 4;

/// The serial line and its ends of the queues.
pub struct Serial {
    usart: USART3,
    received: Producer<'static, u8, RECEIVE_QUEUE>,
    to_transmit: Consumer<'static, u8, TRANSMIT_QUEUE>,
    /// Whether the queue was full and bytes were lost.
    has_lost: bool,
}

impl Serial {
    /// Sets the serial line up.
    pub fn new(
        usart: USART3,
        received: Producer<'static, u8, RECEIVE_QUEUE>,
        to_transmit: Consumer<'static, u8, TRANSMIT_QUEUE>,
    ) -> Self {
        // SAFETY: mantissa and fraction side by side, as with 16 samples for each bit.
        usart.brr().write(|w| unsafe { w.bits(CYCLES_PER_BIT) });
        usart.cr1().write(|w| {
            w.ue().enabled().te().enabled().re().enabled();
            w.rxneie().enabled()
        });
        Self {
            usart,
            received,
            to_transmit,
            has_lost: false,
        }
    }

    /// Handles the interrupt: reads the received byte and writes the next one. Returns whether the
    /// adapter has to run.
    pub fn on_interrupt(&mut self) -> bool {
        let status = self.usart.sr().read();
        let mut is_adapter_due = false;
        // Reading the data register after the status clears both.
        if status.rxne().bit() || status.ore().bit() {
            let byte = self.usart.dr().read().dr().bits() as u8;
            let is_valid = !(status.fe().bit() || status.nf().bit());
            if status.rxne().bit() {
                self.receive(if is_valid { byte } else { DAMAGED });
            }
            if status.ore().bit() {
                self.receive(DAMAGED);
            }
            is_adapter_due = byte == b'\r' || self.received.len() >= RECEIVE_THRESHOLD;
        }
        if status.txe().bit() {
            is_adapter_due |= self.transmit();
        }
        is_adapter_due
    }

    fn receive(&mut self, byte: u8) {
        // A loss is marked at its position, between the bytes before and after it.
        if self.has_lost && self.received.enqueue(DAMAGED).is_ok() {
            self.has_lost = false;
        }
        self.has_lost = self.has_lost || self.received.enqueue(byte).is_err();
    }

    /// Writes the next byte to the line. Returns whether there is room for another eighth of the
    /// queue.
    fn transmit(&mut self) -> bool {
        let next = self.to_transmit.dequeue();
        if let Some(byte) = next {
            self.usart.dr().write(|w| w.dr().set(byte.into()));
        }
        let is_active = next.is_some();
        self.usart.cr1().modify(|_, w| w.txeie().bit(is_active));
        is_active && self.to_transmit.len().is_multiple_of(TRANSMIT_QUEUE / 8)
    }
}
