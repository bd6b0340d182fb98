//! The three transmit mailboxes.

use super::super::{Frame, Id};

const COUNT: usize = 3;

/// A mailbox and its registers.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Mailbox {
    /// `TIxR`, `TDTxR`, `TDLxR`, `TDHxR`; `TXRQ` is [`Mailbox::is_pending`].
    pub words: [u32; 4],
    pub is_pending: bool,
    /// Whether it is emptied after the present attempt, independently of the outcome.
    pub is_aborted: bool,
    /// Position in the order of requests.
    pub order: u64,
    /// `RQCP`, `TXOK`, `ALST`, `TERR`: the low four bits of its byte in `TSR`.
    pub flags: Flags,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Flags {
    pub is_complete: bool,
    pub is_ok: bool,
    pub lost_arbitration: bool,
    pub had_error: bool,
}

impl Flags {
    fn bits(self) -> u64 {
        u64::from(self.is_complete)
            | u64::from(self.is_ok) << 1
            | u64::from(self.lost_arbitration) << 2
            | u64::from(self.had_error) << 3
    }
}

impl Mailbox {
    /// Its frame.
    pub fn frame(&self) -> Frame {
        let [identifier, control, low, high] = self.words;
        let id = if identifier & 1 << 2 != 0 {
            Id::Extended(identifier >> 3)
        } else {
            Id::Standard((identifier >> 21) as u16)
        };
        let data = u64::from(low) | u64::from(high) << 32;
        Frame {
            id,
            remote: identifier & 1 << 1 != 0,
            dlc: (control & 0xf) as u8,
            data: data.to_le_bytes(),
        }
    }

    /// Whether the time stamp replaces its last two bytes.
    pub fn sends_stamp(&self) -> bool {
        self.words[1] & 1 << 8 != 0 && self.words[1] & 0xf == 8
    }

    /// Empties it.
    pub fn complete(&mut self, flags: Flags) {
        self.is_pending = false;
        self.is_aborted = false;
        self.flags = Flags {
            is_complete: true,
            ..flags
        };
    }
}

#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Mailboxes {
    pub boxes: [Mailbox; COUNT],
    requests: u64,
}

impl Mailboxes {
    /// `TXRQ`.
    pub fn request(&mut self, index: usize) {
        self.requests += 1;
        let mailbox = &mut self.boxes[index];
        if !mailbox.is_pending {
            mailbox.is_pending = true;
            mailbox.order = self.requests;
            mailbox.flags = Flags::default();
        }
    }

    /// Whether a mailbox is pending.
    pub fn has_pending(&self) -> bool {
        self.boxes.iter().any(|mailbox| mailbox.is_pending)
    }

    /// Pending mailboxes in the order of transmission.
    pub fn in_order(&self, by_request: bool) -> Vec<usize> {
        let mut pending: Vec<usize> = (0..COUNT).filter(|i| self.boxes[*i].is_pending).collect();
        // Both sorts are stable: equal mailboxes remain in the order of their numbers.
        if by_request {
            pending.sort_by_key(|i| self.boxes[*i].order);
        } else {
            pending.sort_by(|a, b| {
                let frame = |i: &usize| self.boxes[*i].frame();
                frame(a).arbitrates(&frame(b))
            });
        }
        pending
    }

    /// `TSR`.
    pub fn register(&self, by_request: bool) -> u64 {
        let pending = self.in_order(by_request);
        let mut value = 0;
        for (index, mailbox) in self.boxes.iter().enumerate() {
            value |= mailbox.flags.bits() << (8 * index);
            value |= u64::from(!mailbox.is_pending) << (26 + index);
        }
        let lowest = pending.last().copied();
        let free = self.boxes.iter().position(|mailbox| !mailbox.is_pending);
        value |= (free.or(lowest).unwrap_or(0) as u64) << 24;
        if let Some(lowest) = lowest.filter(|_| pending.len() > 1) {
            value |= 1 << (29 + lowest);
        }
        value
    }

    /// Whether a transmit interrupt is due.
    pub fn has_complete(&self) -> bool {
        self.boxes.iter().any(|mailbox| mailbox.flags.is_complete)
    }
}
