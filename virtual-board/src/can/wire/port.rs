//! A station outside the emulated boards: a master, a tool, a recorder.

use std::collections::VecDeque;

use super::super::{BitTiming, ErrorState, Frame};
use super::{Outcome, Station, Transfer};

/// An error-free station that sends what it is given and keeps what it hears.
#[derive(Debug, Clone)]
pub struct Port {
    /// Its bit timing.
    pub timing: BitTiming,
    /// Whether it acknowledges; a silent one only listens.
    pub speaks: bool,
    queue: VecDeque<(u64, Frame)>,
    heard: Vec<(u64, Frame)>,
}

impl Port {
    /// A port at this rate, bit/s.
    ///
    /// ```
    /// use virtual_board::can::{BitTiming, Port};
    ///
    /// assert_eq!(Port::at_rate(500_000).timing.bit_ps, 2_000_000);
    /// ```
    pub fn at_rate(bit_s: u32) -> Self {
        Self {
            timing: BitTiming::at_rate(bit_s),
            speaks: true,
            queue: VecDeque::new(),
            heard: Vec::new(),
        }
    }

    /// Sends a frame, not before this instant, ns, and after those that wait already.
    pub fn send(&mut self, not_before_ns: u64, frame: Frame) {
        self.queue.push_back((not_before_ns, frame));
    }

    /// Every frame of others that was delivered since the last call, with its end, ns.
    pub fn take_heard(&mut self) -> Vec<(u64, Frame)> {
        std::mem::take(&mut self.heard)
    }

    /// Frames that wait to be sent.
    pub fn waiting(&self) -> usize {
        self.queue.len()
    }

    pub(super) fn due_ns(&self) -> Option<u64> {
        let front = self.queue.front().filter(|_| self.speaks);
        front.map(|(due_ns, _)| *due_ns)
    }

    pub(super) fn station(&self, now_ns: u64) -> Option<Station> {
        let due = self.queue.front().filter(|(due_ns, _)| *due_ns <= now_ns);
        Some(Station {
            timing: self.timing,
            state: ErrorState::Active,
            offer: due.filter(|_| self.speaks).map(|(_, frame)| *frame),
            speaks: self.speaks,
            needs_acknowledge: true,
        })
    }

    pub(super) fn hear(&mut self, at_ns: u64, own_index: usize, transfer: &Transfer) {
        if transfer.outcome != Outcome::Delivered {
            return;
        }
        if transfer.sender == own_index {
            self.queue.pop_front();
        } else if transfer.timing.agrees(&self.timing) {
            self.heard.push((at_ns, transfer.frame));
        }
    }
}
