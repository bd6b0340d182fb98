//! The serial line: USART3, a byte at a time, between the line and two queues.
//!
//! A byte that was lost or came damaged is replaced by one that no command has, so that its line is refused and
//! never understood as another one.

use heapless::spsc::{Consumer, Producer};
use stm32f4xx_hal::pac::USART3;

/// 8 data bits, no parity, one stop bit, at 40 MHz / 20 = 2,000,000 baud.
const CYCLES_PER_BIT: u16 = 20;

/// Bytes that may wait for the adapter: 5 ms of the line.
pub const INCOMING: usize = 1024;

/// Bytes that may wait for the line: 5 ms of it.
pub const OUTGOING: usize = 1024;

/// Makes a line that it is in no command.
const DAMAGED: u8 = 0xff;

/// The adapter is told of bytes that are no whole line yet when there are so many.
const MANY: usize = INCOMING / 4;

/// The line, and the line's ends of the queues.
pub struct Serial {
    usart: USART3,
    heard: Producer<'static, u8, INCOMING>,
    to_say: Consumer<'static, u8, OUTGOING>,
    has_lost: bool,
}

impl Serial {
    /// Sets the line up.
    pub fn new(
        usart: USART3,
        heard: Producer<'static, u8, INCOMING>,
        to_say: Consumer<'static, u8, OUTGOING>,
    ) -> Self {
        // SAFETY: mantissa and fraction side by side, as 16 samples a bit have them.
        usart.brr().write(|w| unsafe { w.bits(CYCLES_PER_BIT) });
        usart.cr1().write(|w| {
            w.ue().enabled().te().enabled().re().enabled();
            w.rxneie().enabled()
        });
        Self {
            usart,
            heard,
            to_say,
            has_lost: false,
        }
    }

    /// Fetches the byte that came in and puts out the next one; whether there is something to do for the adapter.
    pub fn serve(&mut self) -> bool {
        let status = self.usart.sr().read();
        let mut calls = false;
        // Reading the data register after the status clears both.
        if status.rxne().bit() || status.ore().bit() {
            let byte = self.usart.dr().read().dr().bits() as u8;
            let is_whole = !(status.fe().bit() || status.nf().bit());
            if status.rxne().bit() {
                self.take(if is_whole { byte } else { DAMAGED });
            }
            if status.ore().bit() {
                self.take(DAMAGED);
            }
            calls = byte == b'\r' || self.heard.len() >= MANY;
        }
        if status.txe().bit() {
            calls |= self.put();
        }
        calls
    }

    fn take(&mut self, byte: u8) {
        // What is lost between two bytes is told between them.
        if self.has_lost && self.heard.enqueue(DAMAGED).is_ok() {
            self.has_lost = false;
        }
        self.has_lost = self.has_lost || self.heard.enqueue(byte).is_err();
    }

    /// Puts the next byte onto the line; whether there is room for many more.
    fn put(&mut self) -> bool {
        let next = self.to_say.dequeue();
        if let Some(byte) = next {
            self.usart.dr().write(|w| w.dr().set(byte.into()));
        }
        let is_on = next.is_some();
        self.usart.cr1().modify(|_, w| w.txeie().bit(is_on));
        is_on && self.to_say.len().is_multiple_of(OUTGOING / 8)
    }
}
