//! SYNC producer and consumer (CiA 301, 7.2.5).

use crate::Abort;
use crate::message::{IDENTIFIER, Message, cob_id_change_allowed};
use crate::timer::Timer;

/// Bit 30 of 1005h: the node generates SYNC.
const PRODUCE: u32 = 1 << 30;

/// SYNC producer and consumer with objects 1005h, 1006h, 1007h and 1019h.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SyncService {
    /// 0 until 1005h is set, which disables reception: identifier 0 is NMT.
    cob_id: u32,
    period_us: u32,
    window_us: u32,
    overflow: u8,
    counter: u8,
    timer: Timer,
    pending: bool,
    /// The synchronous window after the last SYNC that was received or sent.
    window: Timer,
}

/// A received or transmitted SYNC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sync {
    pub counter: Option<u8>,
    pub length_ok: bool,
}

impl SyncService {
    pub const NEW: Self = Self {
        cob_id: 0,
        period_us: 0,
        window_us: 0,
        overflow: 0,
        counter: 0,
        timer: Timer::EXPIRED,
        pending: false,
        window: Timer::EXPIRED,
    };

    /// Resets the counter when the node leaves STOPPED (CiA 301, 7.2.5).
    pub fn restart_counter(&mut self) {
        self.counter = 0;
    }

    /// Identifier of the consumed SYNC frames.
    pub fn identifier(&self) -> Option<u32> {
        (self.cob_id != 0).then_some(self.cob_id & IDENTIFIER)
    }

    pub fn is_for(&self, message: &Message) -> bool {
        !message.remote && self.identifier() == Some(message.id)
    }

    pub fn receive(&mut self, payload: &[u8]) -> Sync {
        self.window = Timer::from_us(self.window_us);
        let length_ok = payload.len() == usize::from(self.overflow != 0);
        let counter = if self.overflow == 0 {
            None
        } else {
            payload.first().copied()
        };
        Sync { counter, length_ok }
    }

    pub fn advance(&mut self, elapsed: Timer) {
        self.timer.advance(elapsed);
        self.window.advance(elapsed);
    }

    /// Returns a SYNC if the producer's period has elapsed; it also counts as received.
    pub fn tick(&mut self) -> Option<Sync> {
        let produces = self.cob_id & PRODUCE != 0 && self.period_us != 0;
        if !produces
            || !self
                .timer
                .restart_if_expired(Timer::from_us(self.period_us))
        {
            return None;
        }
        self.pending = true;
        self.window = Timer::from_us(self.window_us);
        if self.overflow != 0 {
            self.counter = if self.counter >= self.overflow {
                1
            } else {
                self.counter + 1
            };
        }
        Some(Sync {
            counter: (self.overflow != 0).then_some(self.counter),
            length_ok: true,
        })
    }

    pub fn transmit(&mut self) -> Option<Message> {
        if !core::mem::take(&mut self.pending) {
            return None;
        }
        let counter = [self.counter];
        let data: &[u8] = if self.overflow == 0 { &[] } else { &counter };
        Some(Message::new(self.cob_id & IDENTIFIER, data))
    }

    /// Whether the synchronous window length 1007h has elapsed.
    pub fn window_closed(&self) -> bool {
        self.window_us != 0 && self.window.is_overdue()
    }

    pub fn cob_id(&self) -> u32 {
        self.cob_id
    }

    pub fn set_cob_id(&mut self, new: u32) -> Result<(), Abort> {
        // The identifier must not change while SYNC is generated (CiA 301, 7.5.2.5).
        if !cob_id_change_allowed(new, self.cob_id, new & self.cob_id & PRODUCE != 0) {
            return Err(Abort::Value);
        }
        self.cob_id = new & !(1 << 31);
        self.counter = 0;
        self.pending = false;
        self.timer = Timer::from_us(self.period_us);
        Ok(())
    }

    pub fn period_us(&self) -> u32 {
        self.period_us
    }

    /// Periods above 35 min are refused.
    pub fn set_period(&mut self, period_us: u32) -> Result<(), Abort> {
        if period_us > Timer::LONGEST_US {
            return Err(Abort::TooHigh);
        }
        self.period_us = period_us;
        self.timer = Timer::from_us(period_us);
        self.counter = 0;
        Ok(())
    }

    pub fn window_us(&self) -> u32 {
        self.window_us
    }

    pub fn set_window(&mut self, window_us: u32) {
        self.window_us = window_us;
    }

    pub fn overflow(&self) -> u8 {
        self.overflow
    }

    pub fn set_overflow(&mut self, value: u8) -> Result<(), Abort> {
        if self.period_us != 0 {
            return Err(Abort::DeviceState);
        }
        if value == 1 || value > 240 {
            return Err(Abort::Value);
        }
        self.overflow = value;
        self.counter = 0;
        Ok(())
    }
}
