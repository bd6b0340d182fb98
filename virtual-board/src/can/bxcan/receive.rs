//! Reception: filters, FIFOs and their output registers.

use super::super::fifo::Received;
use super::super::{Frame, Id};
use super::{BxCan, mcr};

impl BxCan {
    pub(super) fn store_received(&mut self, frame: &Frame, started_ns: u64) {
        let Some(accepted) = self.filters.accept(frame) else {
            return;
        };
        let received = Received {
            frame: *frame,
            filter: accepted.index,
            stamp: if self.is(mcr::TTCM) {
                self.stamp(started_ns)
            } else {
                0
            },
        };
        let is_locked = self.is(mcr::RFLM);
        self.fifos[accepted.fifo].push(received, is_locked);
    }

    /// `RIxR`, `RDTxR`, `RDLxR`, `RDHxR`.
    pub(super) fn output_registers(&self, fifo: usize) -> [u64; 4] {
        let Some(front) = self.fifos[fifo].front() else {
            return [0; 4];
        };
        let frame = &front.frame;
        let id = match frame.id {
            Id::Standard(id) => u64::from(id) << 21,
            Id::Extended(id) => u64::from(id) << 3 | 1 << 2,
        };
        let data = u64::from_le_bytes(frame.data);
        [
            id | u64::from(frame.remote) << 1,
            u64::from(frame.dlc) | u64::from(front.filter) << 8 | u64::from(front.stamp) << 16,
            data & 0xffff_ffff,
            data >> 32,
        ]
    }
}
