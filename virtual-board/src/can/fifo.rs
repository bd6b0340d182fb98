//! A receive FIFO of bxCAN: three frames deep (RM0090, section 32.7.3).

use std::collections::VecDeque;

use super::Frame;

const DEPTH: usize = 3;

/// A frame in a FIFO.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Received {
    pub frame: Frame,
    pub filter: u8,
    /// Time stamp of the start of the frame, in bit times.
    pub stamp: u16,
}

#[derive(Debug, Clone, Default)]
pub(super) struct Fifo {
    frames: VecDeque<Received>,
    pub is_full: bool,
    pub has_overrun: bool,
}

impl Fifo {
    pub fn front(&self) -> Option<&Received> {
        self.frames.front()
    }

    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Stores a frame. In a full FIFO, a locked one discards the new frame, and an unlocked one the
    /// last stored frame.
    pub fn push(&mut self, received: Received, is_locked: bool) {
        if self.frames.len() < DEPTH {
            self.frames.push_back(received);
            self.is_full |= self.frames.len() == DEPTH;
            return;
        }
        self.has_overrun = true;
        if !is_locked {
            self.frames.pop_back();
            self.frames.push_back(received);
        }
    }

    pub fn release(&mut self) {
        self.frames.pop_front();
    }

    /// `RFxR`: pending, full, overrun.
    pub fn register(&self) -> u64 {
        self.frames.len() as u64 | u64::from(self.is_full) << 3 | u64::from(self.has_overrun) << 4
    }

    /// Writes `RFxR`: ones clear flags and release the output mailbox.
    pub fn write(&mut self, value: u64) {
        self.is_full &= value & 1 << 3 == 0;
        self.has_overrun &= value & 1 << 4 == 0;
        if value & 1 << 5 != 0 {
            self.release();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Id;
    use super::*;

    fn received(id: u16) -> Received {
        Received {
            frame: Frame::data_frame(Id::Standard(id), &[]),
            filter: 0,
            stamp: 0,
        }
    }

    fn ids(fifo: &mut Fifo) -> Vec<u32> {
        let mut ids = Vec::new();
        while let Some(front) = fifo.front() {
            ids.push(front.frame.id.value());
            fifo.release();
        }
        ids
    }

    #[test]
    fn a_fourth_frame_replaces_the_third() {
        let mut fifo = Fifo::default();
        (1..=4).for_each(|id| fifo.push(received(id), false));
        assert_eq!(fifo.register(), 3 | 1 << 3 | 1 << 4);
        assert_eq!(ids(&mut fifo), [1, 2, 4]);
    }

    #[test]
    fn a_locked_fifo_discards_the_newest_frame() {
        let mut fifo = Fifo::default();
        (1..=4).for_each(|id| fifo.push(received(id), true));
        assert!(fifo.has_overrun);
        assert_eq!(ids(&mut fifo), [1, 2, 3]);
    }

    #[test]
    fn flags_are_cleared_by_ones_and_the_oldest_frame_is_released() {
        let mut fifo = Fifo::default();
        (1..=4).for_each(|id| fifo.push(received(id), false));
        fifo.write(1 << 5);
        assert_eq!(fifo.register(), 2 | 1 << 3 | 1 << 4);
        fifo.write(1 << 3 | 1 << 4);
        assert_eq!(fifo.register(), 2);
    }
}
