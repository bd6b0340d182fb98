//! Transmission, reception, and the end of frames.

use rigless::chip::can::{BUS_IDLE_BITS, INTERMISSION_BITS};

use super::super::{ErrorCounters, ErrorState, Frame, Outcome, Transfer, WireFault, arbitrate};
use super::filters::{Filters, list};
use super::registers::{LastError, cccr, ir};
use super::{FdCan, FrameInProgress, Mode};

/// Bytes of an element for a frame of eight bytes.
const ELEMENT: u32 = 16;

/// Idle sequences of a recovery from bus-off.
const RECOVERY_SEQUENCES: u32 = 129;

impl FdCan {
    /// The buffer that is transmitted next, the one with the highest priority, and its frame.
    pub(super) fn next_buffer(&self) -> Option<(u32, Frame)> {
        let (start, count) = list(self.settings.buffers, 0x3f);
        (0..count)
            .filter(|buffer| self.pending >> buffer & 1 != 0)
            .map(|buffer| (buffer, self.ram.frame(start + ELEMENT * buffer)))
            .min_by(|(_, a), (_, b)| a.arbitrates(b))
    }

    /// Starts a frame in internal loop-back mode.
    pub(super) fn begin_internal(&mut self, now_ns: u64) {
        if self.current.is_some() {
            return;
        }
        if let Some(transfer) = arbitrate(&[self.station()], WireFault::None, false) {
            let ends_ns = now_ns + transfer.outcome_ns();
            self.begin_frame(ends_ns, transfer, 0, true);
        }
    }

    /// Starts a frame that won the arbitration and lasts until `ends_ns`; `index` is the index of
    /// this controller among the stations.
    pub fn begin(&mut self, ends_ns: u64, transfer: Transfer, index: usize) {
        self.begin_frame(ends_ns, transfer, index, false);
    }

    fn begin_frame(&mut self, ends_ns: u64, transfer: Transfer, index: usize, is_internal: bool) {
        let Some(station) = self.station() else {
            let after_ns = ends_ns + self.bits_ns(INTERMISSION_BITS);
            if let Mode::Joining { ready_ns } = &mut self.mode {
                *ready_ns = (*ready_ns).max(after_ns);
            }
            return;
        };
        let own = self.next_buffer().filter(|_| station.offer.is_some());
        self.current = Some(FrameInProgress {
            transfer,
            ends_ns,
            buffer: own
                .filter(|_| transfer.sender == index)
                .map(|(buffer, _)| buffer),
            index,
            is_internal,
        });
    }

    /// Requests the transmission of buffers.
    pub(super) fn request(&mut self, buffers: u32) {
        self.pending |= buffers;
        self.transmitted &= !buffers;
        self.cancelled &= !buffers;
    }

    /// Cancels buffers: immediately, or after the present attempt.
    pub(super) fn cancel(&mut self, buffers: u32) {
        let buffers = buffers & self.pending;
        let sending = self.current.and_then(|current| current.buffer);
        let sending = sending.map_or(0, |buffer| 1 << buffer);
        self.cancelling |= buffers & sending;
        self.complete_cancellation(buffers & !sending);
    }

    fn complete_cancellation(&mut self, buffers: u32) {
        self.pending &= !buffers;
        self.cancelling &= !buffers;
        self.cancelled |= buffers;
        if buffers & self.settings.cancelled_enabled != 0 {
            self.flags |= ir::TCF;
        }
    }

    /// Ends the frame whose time has elapsed.
    pub(super) fn finish_current(&mut self, now_ns: u64) {
        let Some(current) = self.current.take_if(|current| current.ends_ns <= now_ns) else {
            return;
        };
        match current.buffer {
            Some(buffer) => self.finish_sending(1 << buffer, &current.transfer),
            None if self.is_looped() => {}
            None => self.finish_receiving(&current),
        }
        if self.is_bus_off() {
            // The controller leaves the bus without the program (chapter 56).
            self.control |= cccr::INIT;
            self.mode = Mode::Initialising;
        }
    }

    fn finish_sending(&mut self, buffer: u32, transfer: &Transfer) {
        if transfer.outcome == Outcome::Delivered {
            self.counters.sent();
            self.last_error = LastError::None;
            self.pending &= !buffer;
            self.cancelling &= !buffer;
            self.transmitted |= buffer;
            if buffer & self.settings.complete_enabled != 0 {
                self.flags |= ir::TC;
            }
            if self.is_looped() {
                self.store(&transfer.frame);
            }
            return;
        }
        let error = match transfer.outcome {
            Outcome::Unacknowledged => LastError::Acknowledge,
            Outcome::BitError => LastError::BitDominant,
            _ => LastError::BitRecessive,
        };
        self.counters.send_failed(error == LastError::Acknowledge);
        self.record(error);
        let only_once = if self.is(cccr::DAR) { buffer } else { 0 };
        self.complete_cancellation(buffer & (self.cancelling | only_once));
    }

    fn record(&mut self, error: LastError) {
        self.last_error = error;
        self.flags |= ir::PEA;
    }

    fn finish_receiving(&mut self, current: &FrameInProgress) {
        let transfer = &current.transfer;
        let is_compatible = self
            .timing()
            .is_some_and(|own| own.is_compatible(&transfer.timing));
        let only_listens = self.is(cccr::MON) || self.counters.state() == ErrorState::Passive;
        match transfer.outcome {
            Outcome::Delivered | Outcome::Unacknowledged
                if is_compatible && transfer.is_whole() =>
            {
                self.counters.received();
                self.last_error = LastError::None;
                self.store(&transfer.frame);
            }
            Outcome::Unacknowledged if is_compatible => {
                self.counters.receive_failed(false);
                self.record(LastError::Form);
            }
            Outcome::Disturbed(by) => {
                self.counters.receive_failed(by == Some(current.index));
                self.record(LastError::Stuff);
            }
            _ if !is_compatible && only_listens => {
                self.counters.receive_failed(false);
                self.record(LastError::Stuff);
            }
            _ => {}
        }
    }

    /// Stores a received frame in FIFO 0 if a filter accepts it; a full FIFO discards it.
    fn store(&mut self, frame: &Frame) {
        let filters = Filters {
            standard: self.settings.standard_filters,
            extended: self.settings.extended_filters,
        };
        if !filters.accept(&self.ram, frame) {
            return;
        }
        let (start, size) = list(self.settings.fifo, 0x7f);
        if self.fifo.level >= size {
            self.flags |= ir::RF0L;
            return;
        }
        let put = (self.fifo.get + self.fifo.level) % size;
        self.ram.store(start + ELEMENT * put, frame);
        self.fifo.level += 1;
        self.flags |= ir::RF0N;
        if self.fifo.level == size {
            self.flags |= ir::RF0F;
        }
    }

    /// `RXF0A`: releases the frames up to this index.
    pub(super) fn acknowledge(&mut self, index: u32) {
        let (_, size) = list(self.settings.fifo, 0x7f);
        if size == 0 || index >= size {
            return;
        }
        let released = (index + size - self.fifo.get) % size + 1;
        self.fifo.level = self.fifo.level.saturating_sub(released);
        self.fifo.get = (index + 1) % size;
    }

    /// Follows `INIT`, and joins the bus when it is time.
    pub(super) fn advance_mode(&mut self, now_ns: u64) {
        if self.is(cccr::INIT) {
            self.mode = Mode::Initialising;
            return;
        }
        match self.mode {
            Mode::Initialising => {
                let sequences = if self.is_bus_off() {
                    RECOVERY_SEQUENCES
                } else {
                    1
                };
                self.mode = Mode::Joining {
                    ready_ns: now_ns + self.bits_ns(sequences * BUS_IDLE_BITS),
                };
            }
            Mode::Joining { ready_ns } if ready_ns <= now_ns => {
                if self.is_bus_off() {
                    self.counters = ErrorCounters::default();
                }
                self.mode = Mode::Running;
            }
            Mode::Joining { .. } | Mode::Running => {}
        }
    }
}
