//! Streams of DMA2 between a peripheral register and a static buffer.
//!
//! The elements of a buffer are atomics: the controller writes them without the compiler's
//! knowledge, and each read returns a whole element. The stream's flag signals the end of a
//! transfer.

use core::sync::atomic::{
    AtomicU8, AtomicU16,
    Ordering::{Acquire, Release},
    fence,
};

use stm32f4xx_hal::dma::StreamX;

use crate::chip::pac::{
    DMA2,
    dma2::{
        self, ST,
        st::cr::{CIRC, DIR, PL, PSIZE},
    },
};

/// Memory that a stream may read and write: static, with atomic elements.
pub trait Buffer {
    /// Its address.
    fn address(&'static self) -> u32;
    /// Width of its elements.
    const WIDTH: PSIZE;
}

impl<const N: usize> Buffer for [AtomicU8; N] {
    const WIDTH: PSIZE = PSIZE::Bits8;
    fn address(&'static self) -> u32 {
        self.as_ptr() as u32
    }
}

impl<const N: usize> Buffer for [AtomicU16; N] {
    const WIDTH: PSIZE = PSIZE::Bits16;
    fn address(&'static self) -> u32 {
        self.as_ptr() as u32
    }
}

/// A configured stream; each transfer moves one buffer.
pub struct DmaStream<const S: u8> {
    items: u16,
}

/// Configuration of the transfers of a stream.
pub struct Transfer {
    /// Request channel, 0 to 7 (RM0090, table 44).
    pub channel: u8,
    /// From or to the peripheral.
    pub direction: DIR,
    /// Address of the peripheral's data register.
    pub register: u32,
    /// Whether transfers repeat.
    pub circular: CIRC,
    /// Priority among the streams.
    pub priority: PL,
}

/// Flags of a stream in the interrupt registers (section 10.5.1): FEIF, DMEIF, TEIF, HTIF, TCIF.
const FLAGS: u32 = 0b11_1101;
const COMPLETE: u32 = 1 << 5;

/// Polls of a stream that stops: an access to the slowest bus takes below 20 cycles.
const STOP_POLLS: u32 = 20;

impl<const S: u8> DmaStream<S> {
    /// Position of the stream's flags in their register.
    const SHIFT: u32 = [0, 6, 16, 22][S as usize % 4];

    /// Sets the stream up, stopped. The token proves that no other code uses the stream's
    /// registers.
    pub fn new<const N: usize, T>(
        _: StreamX<DMA2, S>,
        transfer: &Transfer,
        buffer: &'static [T; N],
    ) -> Self
    where
        [T; N]: Buffer,
    {
        let stream = Self { items: N as u16 };
        set_up(
            stream.registers(),
            transfer,
            <[T; N]>::WIDTH,
            buffer.address(),
        );
        stream
    }

    fn controller() -> &'static dma2::RegisterBlock {
        // SAFETY: the registers exist always; a `DmaStream` accesses those of its own stream and
        // the flag clearing registers, where zeros have no effect.
        unsafe { &*DMA2::ptr() }
    }

    fn registers(&self) -> &'static ST {
        Self::controller().st(S as usize)
    }

    /// Enables an interrupt at the end of a transfer, complete or failed.
    pub fn listen(&mut self) {
        let control = self.registers().cr();
        control.modify(|_, w| w.tcie().set_bit().teie().set_bit());
    }

    /// Starts a transfer of the whole buffer.
    pub fn start(&mut self) {
        self.start_with(self.items);
    }

    /// Starts a transfer of so many elements of the buffer, at most all.
    pub fn start_with(&mut self, items: u16) {
        self.clear();
        let stream = self.registers();
        let items = items.min(self.items);
        stream.ndtr().write(|w| w.ndt().set(items));
        // Reads of the last transfer's data precede this transfer.
        fence(Release);
        stream.cr().modify(|_, w| w.en().set_bit());
    }

    /// Whether a transfer has completed since the last call.
    pub fn take_complete(&mut self) -> bool {
        let controller = Self::controller();
        let flags = if S < 4 {
            controller.lisr().read().bits()
        } else {
            controller.hisr().read().bits()
        };
        // Reads of the transfer's data follow that of its flag.
        fence(Acquire);
        self.clear();
        flags >> Self::SHIFT & COMPLETE != 0
    }

    /// Elements that are left of the transfer, or of this round of a circular one.
    pub fn left(&self) -> u16 {
        let left = self.registers().ndtr().read().ndt().bits();
        // Reads of the buffer follow.
        fence(Acquire);
        left
    }

    /// Aborts a transfer. The stream first ends the access to the bus that it has begun, and its
    /// registers are locked until then (RM0090, section 10.3.14).
    pub fn stop(&mut self) {
        let control = self.registers().cr();
        control.modify(|_, w| w.en().clear_bit());
        let has_stopped = |_: &u32| control.read().en().bit_is_clear();
        // A stream that does not stop within these polls cannot be started again: the next transfer
        // does not complete, which is a lost sample.
        let _ = (0..STOP_POLLS).find(has_stopped);
    }

    fn clear(&mut self) {
        let controller = Self::controller();
        // SAFETY: ones clear this stream's flags, zeros have no effect.
        unsafe {
            if S < 4 {
                controller.lifcr().write(|w| w.bits(FLAGS << Self::SHIFT));
            } else {
                controller.hifcr().write(|w| w.bits(FLAGS << Self::SHIFT));
            }
        }
    }
}

fn set_up(stream: &ST, transfer: &Transfer, width: PSIZE, buffer: u32) {
    stream.cr().write(|w| {
        w.chsel()
            .set(transfer.channel)
            .dir()
            .variant(transfer.direction);
        w.circ()
            .variant(transfer.circular)
            .pl()
            .variant(transfer.priority);
        // Both sides have the width of the buffer's elements, and both are aligned.
        w.minc()
            .set_bit()
            .msize()
            .variant(width)
            .psize()
            .variant(width)
    });
    // SAFETY: `Transfer` gives the address of a data register, `Buffer` that of static memory.
    unsafe {
        stream.par().write(|w| w.bits(transfer.register));
        stream.m0ar().write(|w| w.bits(buffer));
    }
}
