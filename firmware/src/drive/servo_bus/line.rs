//! When a servo answers: after its return delay, and behind the servos before it.
//!
//! Several servos answer to one instruction in turn. Each hears the others: a packet of another
//! servo is one place, and so is the time of a slot without one, as a servo may be missing. An
//! answer that continues the packet of others waits for their bytes instead, and is left out if
//! they are missing.

use servo_bus::{Answer, Bytes, dynamixel};

/// Time of a servo that does not answer, us: its return delay is 508 us at most, and a byte takes
/// 1042 us at 9,600 bit/s. While bytes are received, the time does not elapse.
const SLOT_US: u32 = 2_000;

/// Pause after which a part of a packet is discarded, us: longer than an adapter pauses within one.
const SILENCE_US: u32 = 20_000;

/// The answer that is due, and what has to be heard before it.
#[derive(Debug, Default)]
pub(super) struct Line {
    answer: Bytes,
    /// Return delay, us; `None` without an answer.
    delay_us: Option<u16>,
    /// Answers of other servos before it.
    before: u8,
    /// Bytes of other servos that it continues, and the CRC of those that were heard.
    bytes_before: u16,
    crc: u16,
    is_linked: bool,
    continues: bool,
}

/// What a servo does when the time that it waits for has elapsed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Elapsed {
    /// It transmits its answer: [`super::ServoBus::take_answer`].
    Transmit,
    /// It waits for another time, us.
    Wait(u32),
    /// Nothing: a part of a packet is discarded.
    Silence,
}

impl Line {
    /// A byte of the line.
    pub fn hear(&mut self, byte: u8) {
        if self.delay_us.is_some() && self.bytes_before > 0 {
            self.crc = dynamixel::crc(self.crc, &[byte]);
            self.bytes_before -= 1;
        }
    }

    /// A packet has ended, with this answer of the servo; without one it is of another servo, or
    /// for others.
    pub fn packet(&mut self, answer: Option<Answer>) {
        let Some(answer) = answer else {
            self.before = self.before.saturating_sub(1);
            return;
        };
        self.delay_us = Some(answer.delay_us);
        self.is_linked = answer.is_linked;
        self.before = if answer.is_linked { 0 } else { answer.turn };
        (self.bytes_before, self.crc) = (answer.bytes_before, 0);
        self.continues = answer.bytes_before > 0;
        self.answer = answer.bytes;
    }

    /// Time until the next event, if no byte comes before, us.
    pub fn wait_us(&self) -> Option<u32> {
        Some(match self.delay_us {
            None => SILENCE_US,
            Some(_) if self.before > 0 || self.bytes_before > 0 => SLOT_US,
            // The packet continues at once.
            Some(_) if self.continues => 1,
            Some(delay_us) => u32::from(delay_us).max(1),
        })
    }

    /// The time has elapsed without a byte.
    pub fn elapsed(&mut self) -> Elapsed {
        if self.delay_us.is_none() {
            return Elapsed::Silence;
        }
        if self.bytes_before > 0 {
            self.delay_us = None;
            return Elapsed::Silence;
        }
        if self.before > 0 {
            self.before -= 1;
            return self.wait_us().map_or(Elapsed::Silence, Elapsed::Wait);
        }
        Elapsed::Transmit
    }

    /// The answer, whose length is 0 if it does not fit.
    pub fn take_answer(&mut self, buffer: &mut [u8]) -> usize {
        if self.delay_us.take().is_none() {
            return 0;
        }
        if self.is_linked {
            dynamixel::link(&mut self.answer, self.crc);
        }
        let length = self.answer.len();
        match buffer.get_mut(..length) {
            Some(place) => place.copy_from_slice(&self.answer),
            None => return 0,
        }
        length
    }
}
