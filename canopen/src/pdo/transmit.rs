//! TPDO: from the object dictionary to the bus.

use super::Channel;
use crate::heartbeat::next_on_grid;
use crate::instant::later;
use crate::message::Message;

/// One TPDO. It is sampled when it is triggered, and waits for the bus then.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tpdo {
    pub channel: Channel,
    sample: [u8; 8],
    /// `sample` is to be sent.
    ready: bool,
    /// An event asked for it; for type 0, since the last SYNC.
    requested: bool,
    /// No sooner, by the inhibit time.
    free_us: u64,
    /// The event timer, where there is one.
    due_us: u64,
    /// SYNCs since the last transmission.
    syncs: u8,
    /// The SYNC with the start value was there.
    started: bool,
}

impl Tpdo {
    pub const NEW: Self = Self {
        channel: Channel::NEW,
        sample: [0; 8],
        ready: false,
        requested: false,
        free_us: 0,
        due_us: 0,
        syncs: 0,
        started: false,
    };

    /// The node became OPERATIONAL, or the PDO exists only now. An event-driven PDO is sent once, so that its
    /// consumers know from what they start.
    pub fn start(&mut self, now_us: u64) {
        self.ready = false;
        self.requested = self.channel.event_driven();
        self.free_us = now_us;
        self.restart_timer(now_us);
        self.syncs = 0;
        self.started = false;
    }

    pub fn restart_timer(&mut self, now_us: u64) {
        self.due_us = later(now_us, self.channel.event_us());
    }

    pub fn request(&mut self) {
        self.requested = true;
    }

    /// Whether it is to be sampled now by an event or its timer.
    pub fn tick(&mut self, now_us: u64) -> bool {
        if !self.channel.valid() || !self.channel.event_driven() {
            return false;
        }
        let period = self.channel.event_us();
        if period != 0 && now_us >= self.due_us {
            self.requested = true;
            self.due_us = next_on_grid(self.due_us, period, now_us);
        } else if self.requested && now_us >= self.free_us {
            // The event timer is the longest time between two (CiA 301, 7.2.2).
            self.restart_timer(now_us);
        }
        if !self.requested || now_us < self.free_us {
            return false;
        }
        self.requested = false;
        self.free_us = later(now_us, u64::from(self.channel.inhibit_100us) * 100);
        true
    }

    /// Whether it is to be sampled with this SYNC.
    pub fn sync(&mut self, counter: Option<u8>) -> bool {
        if !self.channel.valid() || !self.channel.synchronous() {
            return false;
        }
        if !self.started {
            self.started = true;
            let start = self.channel.sync_start;
            if let Some(counter) = counter
                && start != 0
            {
                // The SYNC with the start value counts as the first; earlier ones do not count.
                self.started = counter == start;
                self.syncs = self.channel.transmission.saturating_sub(1);
            }
        }
        match self.channel.transmission {
            _ if !self.started => false,
            0 => core::mem::take(&mut self.requested),
            252 => true,
            every => {
                self.syncs = self.syncs.saturating_add(1);
                let due = self.syncs >= every;
                if due {
                    self.syncs = 0;
                }
                due
            }
        }
    }

    /// A remote frame asked for it. Whether it is to be sampled first.
    pub fn remote(&mut self) -> bool {
        self.ready = true;
        !self.channel.synchronous()
    }

    /// Takes a sample; those of type 252 wait to be asked for.
    pub fn set_sample(&mut self, sample: [u8; 8]) {
        self.sample = sample;
        self.ready |= self.channel.transmission != 252;
    }

    pub fn transmit(&mut self, window_closed: bool) -> Option<Message> {
        if !core::mem::take(&mut self.ready) || !self.channel.valid() {
            return None;
        }
        if window_closed && matches!(self.channel.transmission, 0..=240) {
            return None;
        }
        let length = usize::from(self.channel.map.length());
        Some(Message::new(self.channel.id(), self.sample.get(..length)?))
    }
}
