//! Packets in a stream of bytes.

use core::marker::PhantomData;

use crate::bytes::Bytes;

/// What bytes begin with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scan {
    /// A part of a packet.
    Part,
    /// A packet of this length whose check value is right.
    Packet(usize),
    /// A byte that begins no packet.
    Noise,
}

/// How a protocol delimits its packets.
pub trait Framing {
    /// What these bytes begin with.
    fn scan(bytes: &[u8]) -> Scan;
}

/// Finds packets in a stream of bytes. Nothing of a damaged packet but its first byte is skipped: a
/// packet that follows it is found.
#[derive(Debug)]
pub struct Receiver<F> {
    bytes: Bytes,
    /// Length of the packet that was returned last.
    done: usize,
    framing: PhantomData<F>,
}

impl<F> Default for Receiver<F> {
    fn default() -> Self {
        Self {
            bytes: Bytes::default(),
            done: 0,
            framing: PhantomData,
        }
    }
}

impl<F: Framing> Receiver<F> {
    /// A byte of the stream. Call [`Self::next_packet`] until it returns `None` before the next
    /// byte.
    pub fn push(&mut self, byte: u8) {
        if !self.bytes.push(byte) {
            self.bytes.remove(1);
            self.bytes.push(byte);
        }
    }

    /// Discards a part of a packet, after a pause of the stream.
    pub fn discard(&mut self) {
        self.done = 0;
        self.bytes.clear();
    }

    /// The next packet.
    pub fn next_packet(&mut self) -> Option<&[u8]> {
        self.bytes.remove(core::mem::take(&mut self.done));
        let mut noise = 0;
        let length = loop {
            match F::scan(self.bytes.get(noise..)?) {
                Scan::Noise if noise < self.bytes.len() => noise += 1,
                Scan::Packet(length) => break length,
                Scan::Noise | Scan::Part => break 0,
            }
        };
        self.bytes.remove(noise);
        self.done = length;
        self.bytes.get(..length).filter(|packet| !packet.is_empty())
    }
}
