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
    dma::{
        DmaChannel, DmaDataSize, DmaDirection, DmaFlag, StreamX,
        config::Priority,
        traits::{Stream, StreamISR},
    },
    pac::DMA2,
};

/// Something that a stream may read and write: for ever at its place, and atomic.
pub trait Buffer {
    /// Its address.
    fn address(&'static self) -> u32;
    /// The width of its elements.
    const WIDTH: DmaDataSize;
}

impl<const N: usize> Buffer for [AtomicU8; N] {
    const WIDTH: DmaDataSize = DmaDataSize::Byte;
    fn address(&'static self) -> u32 {
        self.as_ptr() as u32
    }
}

impl<const N: usize> Buffer for [AtomicU16; N] {
    const WIDTH: DmaDataSize = DmaDataSize::HalfWord;
    fn address(&'static self) -> u32 {
        self.as_ptr() as u32
    }
}

/// A stream with its wiring; a transfer moves one buffer.
pub struct Lane<const S: u8> {
    stream: StreamX<DMA2, S>,
    items: u16,
}

/// Where a transfer goes, and how it ends.
pub struct Wiring {
    /// The request (RM0090, table 44).
    pub channel: DmaChannel,
    /// From or to the peripheral.
    pub direction: DmaDirection,
    /// The address of the peripheral's data register.
    pub register: u32,
    /// Starts again by itself.
    pub circular: bool,
    /// Who goes first.
    pub priority: Priority,
}

impl<const S: u8> Lane<S>
where
    StreamX<DMA2, S>: Stream + StreamISR,
{
    /// Sets the stream up; at rest.
    pub fn new<const N: usize, T>(
        mut stream: StreamX<DMA2, S>,
        wiring: &Wiring,
        buffer: &'static [T; N],
    ) -> Self
    where
        [T; N]: Buffer,
    {
        let width = <[T; N]>::WIDTH;
        stream.set_channel(wiring.channel);
        stream.set_direction(wiring.direction);
        stream.set_peripheral_address(wiring.register);
        stream.set_memory_address(buffer.address());
        stream.set_memory_increment(true);
        stream.set_circular_mode(wiring.circular);
        stream.set_priority(wiring.priority);
        // SAFETY: both sides have the width of the buffer's elements, and none is unaligned.
        unsafe {
            stream.set_memory_size(width);
            stream.set_peripheral_size(width);
        }
        Self {
            stream,
            items: N as u16,
        }
    }

    /// Asks for an interrupt when a transfer ended, well or not.
    pub fn listen(&mut self) {
        self.stream.listen_transfer_complete();
        self.stream.listen_transfer_error();
    }

    /// Starts a transfer.
    pub fn start(&mut self) {
        self.clear();
        self.stream.set_number_of_transfers(self.items);
        // What was read of the last transfer was read before this one.
        fence(Release);
        // SAFETY: the buffer is a static of as many atomics, see `Buffer`.
        unsafe { self.stream.enable() };
    }

    /// Whether a transfer is complete; notes that it was asked.
    pub fn take_complete(&mut self) -> bool {
        let complete = self.stream.is_transfer_complete();
        // What is read of the transfer is read after its flag.
        fence(Acquire);
        self.clear();
        complete
    }

    /// Ends a transfer that has not come to its end.
    pub fn stop(&mut self) {
        // SAFETY: nobody waits for the rest of the buffer.
        unsafe { self.stream.disable() };
    }

    fn clear(&mut self) {
        use stm32f4xx_hal::ClearFlags;
        self.stream.clear_flags(
            DmaFlag::TransferComplete
                | DmaFlag::HalfTransfer
                | DmaFlag::TransferError
                | DmaFlag::FifoError
                | DmaFlag::DirectModeError,
        );
    }
}
