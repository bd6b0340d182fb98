//! SYNC producer and consumer (CiA 301, 7.2.5).

use crate::Abort;
use crate::message::{IDENTIFIER, Message, may_become};
use crate::timer::Timer;

/// Bit 30 of 1005h: the node generates SYNC.
const PRODUCE: u32 = 1 << 30;

/// Objects 1005h, 1006h, 1007h and 1019h.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Service {
    /// Before it is set there is nothing to receive: NMT's identifier, 0, never gets here.
    cob_id: u32,
    period_us: u32,
    window_us: u32,
    overflow: u8,
    counter: u8,
    due: Timer,
    pending: bool,
    /// The synchronous window after the last SYNC that was received or sent.
    window: Timer,
}

/// What came with a SYNC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sync {
    pub counter: Option<u8>,
    pub length_ok: bool,
}

impl Service {
    pub const NEW: Self = Self {
        cob_id: 0,
        period_us: 0,
        window_us: 0,
        overflow: 0,
        counter: 0,
        due: Timer::OVER,
        pending: false,
        window: Timer::OVER,
    };

    /// CiA 301, 7.2.5: the counter starts anew when the node enters OPERATIONAL from STOPPED.
    pub fn restart_counter(&mut self) {
        self.counter = 0;
    }

    /// That of the frames that it hears.
    pub fn identifier(&self) -> Option<u32> {
        (self.cob_id != 0).then_some(self.cob_id & IDENTIFIER)
    }

    pub fn is_for(&self, message: &Message) -> bool {
        !message.remote && self.identifier() == Some(message.id)
    }

    pub fn receive(&mut self, payload: &[u8]) -> Sync {
        self.window = Timer::us(self.window_us);
        let length_ok = payload.len() == usize::from(self.overflow != 0);
        let counter = if self.overflow == 0 {
            None
        } else {
            payload.first().copied()
        };
        Sync { counter, length_ok }
    }

    pub fn pass(&mut self, elapsed: Timer) {
        self.due.pass(elapsed);
        self.window.pass(elapsed);
    }

    /// Whether a SYNC of the node's own is due; it counts as received, too.
    pub fn tick(&mut self) -> Option<Sync> {
        let produces = self.cob_id & PRODUCE != 0 && self.period_us != 0;
        if !produces || !self.due.repeats(Timer::us(self.period_us)) {
            return None;
        }
        self.pending = true;
        self.window = Timer::us(self.window_us);
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

    /// Whether the synchronous window 1007h is over.
    pub fn window_closed(&self) -> bool {
        self.window_us != 0 && self.window.is_long_over()
    }

    pub fn cob_id(&self) -> u32 {
        self.cob_id
    }

    pub fn set_cob_id(&mut self, new: u32) -> Result<(), Abort> {
        // While SYNC is generated its identifier stays (CiA 301, 7.5.2.5).
        if !may_become(new, self.cob_id, new & self.cob_id & PRODUCE != 0) {
            return Err(Abort::Value);
        }
        self.cob_id = new & !(1 << 31);
        self.counter = 0;
        self.pending = false;
        self.due = Timer::us(self.period_us);
        Ok(())
    }

    pub fn period_us(&self) -> u32 {
        self.period_us
    }

    /// More than 35 min are too long.
    pub fn set_period(&mut self, period_us: u32) -> Result<(), Abort> {
        if period_us > Timer::LONGEST_US {
            return Err(Abort::TooHigh);
        }
        self.period_us = period_us;
        self.due = Timer::us(period_us);
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
