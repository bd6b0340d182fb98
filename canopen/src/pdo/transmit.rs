//! Transmit PDO.

use super::PdoParameters;
use crate::message::Message;
use crate::timer::Timer;

/// One TPDO. It is sampled when triggered, then waits for the bus.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tpdo {
    sample: [u8; 8],
    /// `sample` waits for transmission.
    pending: bool,
    /// An event triggered the PDO; for type 0, since the last SYNC.
    requested: bool,
    /// Inhibit time.
    inhibit: Timer,
    /// Event timer, if used.
    event: Timer,
    /// SYNCs since the last transmission.
    syncs: u8,
    /// The SYNC with the start value was received.
    started: bool,
}

impl Tpdo {
    pub const NEW: Self = Self {
        sample: [0; 8],
        pending: false,
        requested: false,
        inhibit: Timer::EXPIRED,
        event: Timer::EXPIRED,
        syncs: 0,
        started: false,
    };

    /// Restarts the PDO: the node entered OPERATIONAL or the PDO became valid. An event-driven PDO
    /// is transmitted once, so that its consumers receive the initial values.
    pub fn start(&mut self, parameters: &PdoParameters) {
        self.pending = false;
        self.requested = parameters.event_driven();
        self.inhibit = Timer::EXPIRED;
        self.restart_timer(parameters);
        self.syncs = 0;
        self.started = false;
    }

    pub fn restart_timer(&mut self, parameters: &PdoParameters) {
        self.event = Timer::from_ms(parameters.event_ms);
    }

    pub fn request(&mut self) {
        self.requested = true;
    }

    pub fn advance(&mut self, elapsed: Timer) {
        self.inhibit.advance(elapsed);
        self.event.advance(elapsed);
    }

    /// Whether an event or the event timer requires a sample now.
    pub fn tick(&mut self, parameters: &PdoParameters) -> bool {
        if !parameters.valid() || !parameters.event_driven() {
            return false;
        }
        let period_ms = parameters.event_ms;
        if period_ms != 0 && self.event.restart_if_expired(Timer::from_ms(period_ms)) {
            self.requested = true;
        } else if self.requested && self.inhibit.is_expired() {
            // The event timer is the maximum interval between two transmissions (CiA 301, 7.2.2).
            self.restart_timer(parameters);
        }
        if !self.requested || !self.inhibit.is_expired() {
            return false;
        }
        self.requested = false;
        self.inhibit = Timer::from_100us(parameters.inhibit_100us);
        true
    }

    /// Whether this SYNC requires a sample.
    pub fn sync(&mut self, parameters: &PdoParameters, counter: Option<u8>) -> bool {
        if !parameters.valid() || !parameters.synchronous() {
            return false;
        }
        if !self.started {
            self.started = true;
            let start = parameters.sync_start;
            if let Some(counter) = counter
                && start != 0
            {
                // Counting starts with the SYNC of the start value, which is the first.
                self.started = counter == start;
                self.syncs = parameters.transmission.saturating_sub(1);
            }
        }
        match parameters.transmission {
            _ if !self.started => false,
            0 => core::mem::take(&mut self.requested),
            252 => true,
            every => {
                self.syncs = self.syncs.saturating_add(1);
                let is_complete = self.syncs >= every;
                if is_complete {
                    self.syncs = 0;
                }
                is_complete
            }
        }
    }

    /// A remote frame requests the PDO. Returns whether it must be sampled first: SYNC samples
    /// synchronous PDOs, except before the first SYNC.
    pub fn remote(&mut self, parameters: &PdoParameters) -> bool {
        self.pending = true;
        !parameters.synchronous() || !self.started
    }

    /// Sets the sample; a PDO of type 252 is transmitted only on a remote request.
    pub fn set_sample(&mut self, parameters: &PdoParameters, sample: [u8; 8]) {
        self.sample = sample;
        self.pending |= parameters.transmission != 252;
    }

    pub fn transmit(&mut self, parameters: &PdoParameters, window_closed: bool) -> Option<Message> {
        if !core::mem::take(&mut self.pending) || !parameters.valid() {
            return None;
        }
        if window_closed && matches!(parameters.transmission, 0..=240) {
            return None;
        }
        Some(Message {
            id: parameters.id(),
            remote: false,
            length: parameters.map.length(),
            data: self.sample,
        })
    }
}
