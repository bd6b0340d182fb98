//! The slcan adapter with its queues: commands from the serial line to the bus, frames from the bus
//! to the serial line.

use canopen::{
    CanFrame,
    slcan::{Adapter, SlcanLine},
};
use heapless::spsc::{Consumer, Producer};

use super::serial::{RECEIVE_QUEUE, TRANSMIT_QUEUE};

/// A frame with its time of reception, us modulo 2^32.
pub type StampedFrame = (CanFrame, u32);

/// Length of the queue of received frames: 24 ms of a fully loaded bus at 1 Mbit/s.
pub const FRAME_QUEUE: usize = 512;

/// Room in the transmit queue that frames leave free for answers: more than the longest answer.
const ANSWER_ROOM: usize = 64;

/// Room for the longest line.
const LINE_ROOM: usize = 36;

/// The adapter and its ends of the queues.
pub struct SlcanAdapter {
    adapter: Adapter,
    commands: Consumer<'static, u8, RECEIVE_QUEUE>,
    frames: Consumer<'static, StampedFrame, FRAME_QUEUE>,
    lines: Producer<'static, u8, TRANSMIT_QUEUE>,
    /// Time of the last update since the start, us.
    now_us: u64,
}

impl SlcanAdapter {
    /// A closed adapter.
    pub fn new(
        commands: Consumer<'static, u8, RECEIVE_QUEUE>,
        frames: Consumer<'static, StampedFrame, FRAME_QUEUE>,
        lines: Producer<'static, u8, TRANSMIT_QUEUE>,
    ) -> Self {
        Self {
            adapter: Adapter::new(*b"0001"),
            commands,
            frames,
            lines,
            now_us: 0,
        }
    }

    /// Updates the time, us modulo 2^32; call this at least once in 35 minutes.
    pub fn update_time(&mut self, now_us: u32) {
        self.now_us = self.full_time_us(now_us);
    }

    /// Full time of an instant within 35 minutes of the last update.
    fn full_time_us(&self, us: u32) -> u64 {
        let difference = us.wrapping_sub(self.now_us as u32).cast_signed();
        self.now_us.saturating_add_signed(difference.into())
    }

    fn room(&self) -> usize {
        self.lines.capacity().saturating_sub(self.lines.len())
    }

    fn write(&mut self, text: &SlcanLine) {
        for byte in text.as_bytes() {
            // The callers have checked that there is room.
            let _ = self.lines.enqueue(*byte);
        }
    }

    /// Executes the received commands, while there is space for their responses. Returns whether
    /// there is an answer.
    pub fn execute_commands(
        &mut self,
        mut receive: impl FnMut(&mut Adapter, u8) -> Option<SlcanLine>,
    ) -> bool {
        let mut has_written = false;
        while self.room() >= LINE_ROOM {
            let Some(byte) = self.commands.dequeue() else {
                break;
            };
            if let Some(answer) = receive(&mut self.adapter, byte) {
                self.write(&answer);
                has_written = true;
            }
        }
        has_written
    }

    /// Writes the received frames to the serial line, while there is space. Returns whether it
    /// wrote any.
    pub fn forward_frames(&mut self) -> bool {
        let mut has_written = false;
        while self.room() >= LINE_ROOM + ANSWER_ROOM {
            let Some((frame, us)) = self.frames.dequeue() else {
                break;
            };
            if let Some(line) = self.adapter.frame(&frame, self.full_time_us(us)) {
                self.write(&line);
                has_written = true;
            }
        }
        has_written
    }
}
