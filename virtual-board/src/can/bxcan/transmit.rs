//! Transmission, and the end of frames.

use super::super::{ErrorState, Frame, Outcome, Transfer, WireFault, arbitrate};
use super::mailboxes::Flags;
use super::status::LastError;
use super::{BxCan, FrameInProgress, btr, mcr};

impl BxCan {
    fn next_mailbox(&self) -> Option<usize> {
        let order = self.mailboxes.in_order(self.is(mcr::TXFP));
        order.first().copied()
    }

    /// The frame to be transmitted next, with the time stamp of `TGT`.
    pub(super) fn offer(&self, now_ns: u64) -> Option<Frame> {
        let mailbox = &self.mailboxes.boxes[self.next_mailbox()?];
        let mut frame = mailbox.frame();
        if self.is(mcr::TTCM) && mailbox.sends_stamp() {
            frame.data[6..].copy_from_slice(&self.stamp(now_ns).to_le_bytes());
        }
        Some(frame)
    }

    /// Whether frames remain within the controller: silent loop-back mode.
    pub(super) fn is_internal(&self) -> bool {
        self.bit_timing & (btr::LBKM | btr::SILM) == btr::LBKM | btr::SILM
    }

    /// Starts a frame in silent loop-back mode.
    pub(super) fn begin_internal(&mut self, now_ns: u64) {
        if self.current.is_some() {
            return;
        }
        let Some(transfer) = arbitrate(&[self.station(now_ns)], WireFault::None, false) else {
            return;
        };
        let ends_ns = now_ns + transfer.outcome_ns();
        self.begin_frame(now_ns, ends_ns, transfer, 0, true);
    }

    /// Starts a frame that won the arbitration and lasts until `ends_ns`; `index` is the index of
    /// this controller among the stations. The owner of a shared bus calls this, and then
    /// [`BxCan::schedule`].
    pub fn begin(&mut self, now_ns: u64, ends_ns: u64, transfer: Transfer, index: usize) {
        self.begin_frame(now_ns, ends_ns, transfer, index, false);
    }

    fn begin_frame(
        &mut self,
        now_ns: u64,
        ends_ns: u64,
        transfer: Transfer,
        index: usize,
        is_internal: bool,
    ) {
        let Some(station) = self.station(now_ns) else {
            self.on_traffic(ends_ns);
            return;
        };
        let own = self.next_mailbox().filter(|_| station.offer.is_some());
        let mailbox = own.filter(|_| transfer.sender == index);
        if let Some(lost) = own.filter(|_| mailbox.is_none()) {
            self.lose_arbitration(lost);
        }
        if let Some(sent) = mailbox {
            self.stamp_mailbox(sent, now_ns);
        }
        self.current = Some(FrameInProgress {
            transfer,
            ends_ns,
            started_ns: now_ns,
            mailbox,
            index,
            is_internal,
        });
    }

    fn lose_arbitration(&mut self, index: usize) {
        let only_once = self.is(mcr::NART);
        let mailbox = &mut self.mailboxes.boxes[index];
        mailbox.flags.lost_arbitration = true;
        if only_once || mailbox.is_aborted {
            mailbox.complete(mailbox.flags);
        }
    }

    /// `TDTxR.TIME`.
    fn stamp_mailbox(&mut self, index: usize, now_ns: u64) {
        if !self.is(mcr::TTCM) {
            return;
        }
        let stamp = self.stamp(now_ns);
        let mailbox = &mut self.mailboxes.boxes[index];
        mailbox.words[1] = mailbox.words[1] & 0xffff | u32::from(stamp) << 16;
    }

    /// Ends the transmission attempt of a mailbox.
    pub(super) fn finish_sending(&mut self, index: usize, transfer: &Transfer) {
        let only_once = self.is(mcr::NART);
        let mailbox = &mut self.mailboxes.boxes[index];
        if transfer.outcome == Outcome::Delivered {
            mailbox.complete(Flags {
                is_ok: true,
                ..Flags::default()
            });
            self.counters.sent();
            self.status.record(LastError::None);
            return;
        }
        mailbox.flags.had_error = true;
        if only_once || mailbox.is_aborted {
            mailbox.complete(mailbox.flags);
        }
        let error = match transfer.outcome {
            Outcome::Unacknowledged => LastError::Acknowledge,
            Outcome::BitError => LastError::BitDominant,
            _ => LastError::BitRecessive,
        };
        self.counters.send_failed(error == LastError::Acknowledge);
        self.status.record(error);
    }

    /// `ABRQ`: aborts immediately, or after the present attempt.
    pub(super) fn abort(&mut self, index: usize) {
        let is_sending = self.current.is_some_and(|c| c.mailbox == Some(index));
        let mailbox = &mut self.mailboxes.boxes[index];
        if !mailbox.is_pending {
            return;
        }
        if is_sending {
            mailbox.is_aborted = true;
        } else {
            mailbox.complete(mailbox.flags);
        }
    }

    /// Ends the frame whose time has elapsed.
    pub(super) fn finish_current(&mut self, now_ns: u64) {
        let Some(current) = self.current.take_if(|current| current.ends_ns <= now_ns) else {
            return;
        };
        let transfer = current.transfer;
        match current.mailbox {
            Some(mailbox) => {
                self.finish_sending(mailbox, &transfer);
                if self.is_looped() && transfer.outcome == Outcome::Delivered {
                    self.store_received(&transfer.frame, current.started_ns);
                }
            }
            None if self.is_looped() => {}
            None => self.finish_receiving(&current),
        }
        self.check_bus_off(now_ns);
    }

    fn finish_receiving(&mut self, current: &FrameInProgress) {
        let transfer = &current.transfer;
        let is_compatible = self
            .timing()
            .is_some_and(|own| own.is_compatible(&transfer.timing));
        // Its error flags destroy nothing: the frame of another bit rate continues, and with it the
        // errors that it detects in the frame.
        let only_listens = self.is_silent() || self.counters.state() == ErrorState::Passive;
        match transfer.outcome {
            Outcome::Delivered | Outcome::Unacknowledged
                if is_compatible && transfer.is_whole() =>
            {
                self.counters.received();
                self.status.record(LastError::None);
                self.store_received(&transfer.frame, current.started_ns);
            }
            Outcome::Unacknowledged if is_compatible => {
                self.counters.receive_failed(false);
                self.status.record(LastError::Form);
            }
            Outcome::Disturbed(by) => {
                self.counters.receive_failed(by == Some(current.index));
                self.status.record(LastError::Stuff);
            }
            _ if !is_compatible && only_listens => {
                self.counters.receive_failed(false);
                self.status.record(LastError::Stuff);
            }
            _ => {}
        }
    }
}
