//! The peer of a board's serial line, byte by byte in virtual time: that of the communication
//! board, and the servo bus of an actuator board.
//!
//! `rigless` models the USART: the time of each byte from baud rate register and clock, parity,
//! stop bits, overrun, interrupts. The peer always has the baud rate of the board. It is full
//! duplex: a board does not receive what it transmits.

use std::collections::VecDeque;

use rigless::chip::Timeline;
use rigless::chip::uart::Peer;
use rigless::snapshot::Store;
use rigless::time::VirtualNanos;

/// The peer of the serial line.
#[derive(Debug, Default)]
pub struct SerialPeer {
    queue: VecDeque<(u64, u8)>,
    received: Vec<(u64, u8)>,
}

// A run starts from power-on: snapshots are not used.
impl Store for SerialPeer {}

impl SerialPeer {
    /// Queues bytes for transmission, not before this instant, ns.
    pub fn send(&mut self, not_before_ns: u64, bytes: &[u8]) {
        let bytes = bytes.iter().map(|byte| (not_before_ns, *byte));
        self.queue.extend(bytes);
    }

    /// Number of queued bytes.
    pub fn queued(&self) -> usize {
        self.queue.len()
    }

    /// Discards the bytes that are due: nothing receives them.
    pub(crate) fn lose_due(&mut self, now: VirtualNanos) {
        while self.transmit(now).is_some() {}
    }

    /// Bytes received from the board since the last call, each with the end of its stop bit, ns.
    pub fn take_received(&mut self) -> Vec<(u64, u8)> {
        std::mem::take(&mut self.received)
    }
}

impl Peer for SerialPeer {
    fn receive(&mut self, word: u16, context: &mut Timeline<'_, '_>) {
        self.received.push((context.now().0, word as u8));
    }

    fn transmit(&mut self, now: VirtualNanos) -> Option<u16> {
        let (due_ns, _) = self.queue.front()?;
        if *due_ns > now.0 {
            return None;
        }
        self.queue.pop_front().map(|(_, byte)| byte.into())
    }
}

#[cfg(test)]
mod tests;
