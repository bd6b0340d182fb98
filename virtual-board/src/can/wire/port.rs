//! An external station: a master, a tool, a recorder.

use std::collections::VecDeque;

use super::super::{BitTiming, ErrorCounters, Frame};
use super::{Outcome, Station, Transfer};

/// A station without errors, with a transmit queue and a record of received frames.
#[derive(Debug, Clone)]
pub struct Port {
    /// Its bit timing.
    pub timing: BitTiming,
    /// Whether it only listens: it neither acknowledges nor transmits.
    pub is_silent: bool,
    queue: VecDeque<(u64, Frame)>,
    received: Vec<(u64, Frame)>,
    /// Of its errors it counts missing acknowledgements: alone on the bus it becomes error-passive.
    counters: ErrorCounters,
}

impl Port {
    /// A port with this bit rate, bit/s.
    ///
    /// ```
    /// use virtual_board::can::{BitTiming, Port};
    ///
    /// assert_eq!(Port::at_rate(500_000).timing.bit_ps, 2_000_000);
    /// ```
    pub fn at_rate(bit_s: u32) -> Self {
        Self {
            timing: BitTiming::at_rate(bit_s),
            is_silent: false,
            queue: VecDeque::new(),
            received: Vec::new(),
            counters: ErrorCounters::default(),
        }
    }

    /// Queues a frame for transmission, not before this instant, ns.
    pub fn send(&mut self, not_before_ns: u64, frame: Frame) {
        self.queue.push_back((not_before_ns, frame));
    }

    /// Frames received from other stations since the last call, each with its end, ns.
    pub fn take_received(&mut self) -> Vec<(u64, Frame)> {
        std::mem::take(&mut self.received)
    }

    /// Number of queued frames.
    pub fn queued(&self) -> usize {
        self.queue.len()
    }

    pub(super) fn due_ns(&self) -> Option<u64> {
        let front = self.queue.front().filter(|_| !self.is_silent);
        front.map(|(due_ns, _)| *due_ns)
    }

    pub(super) fn station(&self, now_ns: u64) -> Option<Station> {
        let due = self.queue.front().filter(|(due_ns, _)| *due_ns <= now_ns);
        Some(Station {
            timing: self.timing,
            state: self.counters.state(),
            offer: due.filter(|_| !self.is_silent).map(|(_, frame)| *frame),
            is_silent: self.is_silent,
            needs_acknowledge: true,
        })
    }

    pub(super) fn receive(&mut self, at_ns: u64, own_index: usize, transfer: &Transfer) {
        let is_own = transfer.sender == own_index;
        if is_own && transfer.outcome == Outcome::Unacknowledged {
            self.counters.send_failed(true);
        }
        if transfer.outcome != Outcome::Delivered {
            return;
        }
        if is_own {
            self.counters.sent();
            self.queue.pop_front();
        } else if transfer.timing.is_compatible(&self.timing) {
            self.received.push((at_ns, transfer.frame));
        }
    }
}
