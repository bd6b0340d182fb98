//! The serial line of the communication board: what is at its other end, byte by byte in virtual time.
//!
//! `rigless` models the USART: the time of each byte by the baud rate register and the clock, parity, stop bits,
//! overrun, interrupts. The far end has the board's own baud rate: one that differs cannot be shown.

use std::collections::VecDeque;

use rigless::chip::Timeline;
use rigless::chip::uart::Peer;
use rigless::snapshot::Store;
use rigless::time::VirtualNanos;

/// What is at the other end of the line.
#[derive(Debug, Default)]
pub struct FarEnd {
    to_say: VecDeque<(u64, u8)>,
    heard: Vec<(u64, u8)>,
}

// A run starts from power-on: there is no snapshot to take.
impl Store for FarEnd {}

impl FarEnd {
    /// Says these bytes one after the other, the first not before this instant, ns, and not before those that wait.
    pub fn say(&mut self, not_before_ns: u64, bytes: &[u8]) {
        let bytes = bytes.iter().map(|byte| (not_before_ns, *byte));
        self.to_say.extend(bytes);
    }

    /// Bytes that have not been said yet.
    pub fn waiting(&self) -> usize {
        self.to_say.len()
    }

    /// Every byte of the board since the last call, with the end of its stop bit, ns.
    pub fn take_heard(&mut self) -> Vec<(u64, u8)> {
        std::mem::take(&mut self.heard)
    }
}

impl Peer for FarEnd {
    fn receive(&mut self, word: u16, context: &mut Timeline<'_, '_>) {
        self.heard.push((context.now().0, word as u8));
    }

    fn transmit(&mut self, now: VirtualNanos) -> Option<u16> {
        let (due_ns, _) = self.to_say.front()?;
        if *due_ns > now.0 {
            return None;
        }
        self.to_say.pop_front().map(|(_, byte)| byte.into())
    }
}
