//! TPDO: from the object dictionary to the bus.

use super::Channel;
use crate::message::Message;
use crate::timer::Timer;

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
    inhibit: Timer,
    /// The event timer, where there is one.
    event: Timer,
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
        inhibit: Timer::OVER,
        event: Timer::OVER,
        syncs: 0,
        started: false,
    };

    /// The node became OPERATIONAL, or the PDO exists only now. An event-driven PDO is sent once, so that its
    /// consumers know from what they start.
    pub fn start(&mut self) {
        self.ready = false;
        self.requested = self.channel.event_driven();
        self.inhibit = Timer::OVER;
        self.restart_timer();
        self.syncs = 0;
        self.started = false;
    }

    pub fn restart_timer(&mut self) {
        self.event = Timer::ms(self.channel.event_ms);
    }

    pub fn request(&mut self) {
        self.requested = true;
    }

    pub fn pass(&mut self, elapsed: Timer) {
        self.inhibit.pass(elapsed);
        self.event.pass(elapsed);
    }

    /// Whether it is to be sampled now by an event or its timer.
    pub fn tick(&mut self) -> bool {
        if !self.channel.valid() || !self.channel.event_driven() {
            return false;
        }
        let period_ms = self.channel.event_ms;
        if period_ms != 0 && self.event.repeats(Timer::ms(period_ms)) {
            self.requested = true;
        } else if self.requested && self.inhibit.is_over() {
            // The event timer is the longest time between two (CiA 301, 7.2.2).
            self.restart_timer();
        }
        if !self.requested || !self.inhibit.is_over() {
            return false;
        }
        self.requested = false;
        self.inhibit = Timer::hundreds_us(self.channel.inhibit_100us);
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

    /// A remote frame asked for it. Whether it is to be sampled first: SYNC samples the synchronous ones, but for what
    /// is asked for before there was any.
    pub fn remote(&mut self) -> bool {
        self.ready = true;
        !self.channel.synchronous() || !self.started
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
