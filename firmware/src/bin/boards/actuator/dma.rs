//! Streams of DMA2 between a register and a buffer that lives as long as the program.
//!
//! A buffer is made of atomics: the controller writes it behind the compiler's back, and whoever
//! reads one element reads a whole one. That a transfer is complete is said by the stream's flag.

use core::sync::atomic::{
    AtomicU8, AtomicU16,
    Ordering::{Acquire, Release},
    fence,
};

use stm32f4xx_hal::{
    dma::StreamX,
    pac::{
        DMA2,
        dma2::{
            ST,
            st::cr::{CIRC, DIR, PL, PSIZE},
        },
    },
};

/// Something that a stream may read and write: for ever at its place, and atomic.
pub trait Buffer {
    /// Its address.
    fn address(&'static self) -> u32;
    /// The width of its elements.
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

/// A stream with its wiring; a transfer moves one buffer.
pub struct Lane<const S: u8> {
    items: u16,
}

/// Where a transfer goes, and how it ends.
pub struct Wiring {
    /// The request, 0 to 7 (RM0090, table 44).
    pub channel: u8,
    /// From or to the peripheral.
    pub direction: DIR,
    /// The address of the peripheral's data register.
    pub register: u32,
    /// Starts again by itself.
    pub circular: CIRC,
    /// Who goes first.
    pub priority: PL,
}

/// The flags of a stream in its half of the interrupt registers (section 10.5.1): FEIF, DMEIF, TEIF, HTIF,
/// TCIF.
const FLAGS: u32 = 0b11_1101;
const COMPLETE: u32 = 1 << 5;

impl<const S: u8> Lane<S> {
    /// Where the stream's flags are in their register.
    const SHIFT: u32 = [0, 6, 16, 22][S as usize % 4];

    /// Sets the stream up; at rest. Whoever has the stream's token owns its registers.
    pub fn new<const N: usize, T>(
        _: StreamX<DMA2, S>,
        wiring: &Wiring,
        buffer: &'static [T; N],
    ) -> Self
    where
        [T; N]: Buffer,
    {
        let lane = Self { items: N as u16 };
        set_up(lane.stream(), wiring, <[T; N]>::WIDTH, buffer.address());
        lane
    }

    fn controller() -> &'static stm32f4xx_hal::pac::dma2::RegisterBlock {
        // SAFETY: registers that are always there; a lane touches those of its own stream alone, and
        // the clearing register, where zeros mean nothing.
        unsafe { &*DMA2::ptr() }
    }

    fn stream(&self) -> &'static ST {
        Self::controller().st(S as usize)
    }

    /// Asks for an interrupt when a transfer ended, well or not.
    pub fn listen(&mut self) {
        let control = self.stream().cr();
        control.modify(|_, w| w.tcie().set_bit().teie().set_bit());
    }

    /// Starts a transfer.
    pub fn start(&mut self) {
        self.clear();
        let stream = self.stream();
        stream.ndtr().write(|w| w.ndt().set(self.items));
        // What was read of the last transfer was read before this one.
        fence(Release);
        stream.cr().modify(|_, w| w.en().set_bit());
    }

    /// Whether a transfer is complete; notes that it was asked.
    pub fn take_complete(&mut self) -> bool {
        let controller = Self::controller();
        let flags = if S < 4 {
            controller.lisr().read().bits()
        } else {
            controller.hisr().read().bits()
        };
        // What is read of the transfer is read after its flag.
        fence(Acquire);
        self.clear();
        flags >> Self::SHIFT & COMPLETE != 0
    }

    /// Ends a transfer that has not come to its end.
    pub fn stop(&mut self) {
        self.stream().cr().modify(|_, w| w.en().clear_bit());
    }

    fn clear(&mut self) {
        let controller = Self::controller();
        // SAFETY: ones clear this stream's flags, zeros leave the others'.
        unsafe {
            if S < 4 {
                controller.lifcr().write(|w| w.bits(FLAGS << Self::SHIFT));
            } else {
                controller.hifcr().write(|w| w.bits(FLAGS << Self::SHIFT));
            }
        }
    }
}

#[inline(never)]
fn set_up(stream: &ST, wiring: &Wiring, width: PSIZE, buffer: u32) {
    stream.cr().write(|w| {
        w.chsel()
            .set(wiring.channel)
            .dir()
            .variant(wiring.direction);
        w.circ()
            .variant(wiring.circular)
            .pl()
            .variant(wiring.priority);
        // Both sides have the width of the buffer's elements, and none is unaligned.
        w.minc()
            .set_bit()
            .msize()
            .variant(width)
            .psize()
            .variant(width)
    });
    // SAFETY: a data register and a buffer, by what `Wiring` and `Buffer` say.
    unsafe {
        stream.par().write(|w| w.bits(wiring.register));
        stream.m0ar().write(|w| w.bits(buffer));
    }
}
