//! The handshake of set-points in profile position mode (bits 4, 5 and 6 of the controlword, bit 12 of the statusword).

use super::controlword::{CHANGE_AT_ONCE, NEW_SET_POINT, RELATIVE};

/// The target under way, and one that waits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct SetPoints {
    target: i32,
    waiting: Option<i32>,
    moving: bool,
    bit: bool,
    acknowledged: bool,
}

impl SetPoints {
    /// Stands at a position, without anything to do. A set-point whose bit is set already is none.
    pub fn restart(&mut self, position: i32, word: u16) {
        *self = Self {
            target: position,
            bit: word & NEW_SET_POINT != 0,
            ..Self::default()
        };
    }

    /// Takes the controlword and 607Ah, and says where to go.
    pub fn step(&mut self, word: u16, position: i32) -> i32 {
        let bit = word & NEW_SET_POINT != 0;
        let rises = bit && !self.bit;
        self.bit = bit;
        if rises {
            self.offer(word, position);
        }
        if !bit && self.waiting.is_none() {
            self.acknowledged = false;
        }
        self.target
    }

    fn offer(&mut self, word: u16, position: i32) {
        let last = self.waiting.unwrap_or(self.target);
        let target = if word & RELATIVE == 0 {
            position
        } else {
            last.saturating_add(position)
        };
        if !self.moving || word & CHANGE_AT_ONCE != 0 {
            (self.target, self.waiting, self.moving) = (target, None, true);
        } else if self.waiting.is_none() {
            self.waiting = Some(target);
        } else {
            // No room: not acknowledged, and so the master knows.
            return;
        }
        self.acknowledged = true;
    }

    /// The target was reached: on to the one that waits.
    pub fn reached(&mut self) {
        match self.waiting.take() {
            Some(next) => self.target = next,
            None => self.moving = false,
        }
    }

    /// Bit 12: the set-point was taken, and there is no room for another where one waits.
    pub const fn acknowledged(&self) -> bool {
        self.acknowledged
    }

    /// Whether there is nothing left to do.
    pub const fn idle(&self) -> bool {
        !self.moving
    }
}
