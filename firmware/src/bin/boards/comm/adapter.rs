//! The adapter with its queues: lines to commands, frames to lines.

use canopen::{
    CanFrame,
    slcan::{Adapter, SlcanLine},
};
use heapless::spsc::{Consumer, Producer};

use super::serial::{INCOMING, OUTGOING};

/// A frame, and when it came, us modulo 2^32.
pub type Stamped = (CanFrame, u32);

/// Frames that may wait for the serial line, 24 ms of a full bus at 1 Mbit/s and more of any other.
pub const FRAMES: usize = 512;

/// Room that frames leave on the way to the line, for answers: the longest line is shorter.
const FOR_ANSWERS: usize = 64;

/// The longest line fits.
const ROOM: usize = 36;

/// The adapter between its queues.
pub struct Gateway {
    adapter: Adapter,
    commands: Consumer<'static, u8, INCOMING>,
    frames: Consumer<'static, Stamped, FRAMES>,
    said: Producer<'static, u8, OUTGOING>,
    /// The time of the last millisecond since the start, us.
    now_us: u64,
}

impl Gateway {
    /// A closed adapter.
    pub fn new(
        commands: Consumer<'static, u8, INCOMING>,
        frames: Consumer<'static, Stamped, FRAMES>,
        said: Producer<'static, u8, OUTGOING>,
    ) -> Self {
        Self {
            adapter: Adapter::new(*b"0001"),
            commands,
            frames,
            said,
            now_us: 0,
        }
    }

    /// The time, us modulo 2^32, at least once in 71 minutes.
    pub fn pass_time(&mut self, now_us: u32) {
        self.now_us = self.at_us(now_us);
    }

    /// The whole time of an instant of at most 35 minutes ago, or to come.
    fn at_us(&self, us: u32) -> u64 {
        let ahead = us.wrapping_sub(self.now_us as u32).cast_signed();
        self.now_us.saturating_add_signed(ahead.into())
    }

    fn room(&self) -> usize {
        self.said.capacity().saturating_sub(self.said.len())
    }

    fn say(&mut self, text: &SlcanLine) {
        for byte in text.as_bytes() {
            // There is room: the callers looked.
            let _ = self.said.enqueue(*byte);
        }
    }

    /// Obeys the commands that have come, as far as there is room for answers; whether it said something.
    pub fn obey(&mut self, mut receive: impl FnMut(&mut Adapter, u8) -> Option<SlcanLine>) -> bool {
        let mut has_said = false;
        while self.room() >= ROOM {
            let Some(byte) = self.commands.dequeue() else {
                break;
            };
            if let Some(answer) = receive(&mut self.adapter, byte) {
                self.say(&answer);
                has_said = true;
            }
        }
        has_said
    }

    /// Tells of the frames that have come, as far as there is room; whether it did.
    pub fn report(&mut self) -> bool {
        let mut has_said = false;
        while self.room() >= ROOM + FOR_ANSWERS {
            let Some((frame, us)) = self.frames.dequeue() else {
                break;
            };
            if let Some(line) = self.adapter.frame(&frame, self.at_us(us)) {
                self.say(&line);
                has_said = true;
            }
        }
        has_said
    }
}
