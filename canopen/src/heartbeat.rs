//! Heartbeat producer and consumer (CiA 301, 7.2.8.3.2).

use crate::Abort;
use crate::timer::Timer;

/// Maximum number of monitored nodes; the dictionary determines how many entries 1016h has.
pub(crate) const CONSUMERS: usize = 8;

/// Heartbeat producer with object 1017h.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Producer {
    period_ms: u16,
    timer: Timer,
    pending: bool,
}

impl Producer {
    pub const NEW: Self = Self {
        period_ms: 0,
        timer: Timer::EXPIRED,
        pending: false,
    };

    pub fn period_ms(&self) -> u16 {
        self.period_ms
    }

    /// The first heartbeat after a change of the period is transmitted immediately.
    pub fn set_period(&mut self, period_ms: u16) {
        self.period_ms = period_ms;
        self.timer = Timer::from_ms(period_ms);
        self.pending = period_ms != 0;
    }

    /// Restarts the period after boot-up, which counts as the first heartbeat.
    pub fn restart(&mut self) {
        self.pending = false;
        self.timer = Timer::from_ms(self.period_ms);
    }

    /// Transmits a heartbeat immediately, after a change of the NMT state.
    pub fn announce(&mut self) {
        self.pending = self.period_ms != 0;
    }

    pub fn advance(&mut self, elapsed: Timer) {
        self.timer.advance(elapsed);
    }

    pub fn tick(&mut self) {
        self.pending |= self.period_ms != 0
            && self
                .timer
                .restart_if_expired(Timer::from_ms(self.period_ms));
    }

    pub fn take(&mut self) -> bool {
        core::mem::take(&mut self.pending)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ConsumerState {
    /// No heartbeat received since configuration or since the producer's boot-up.
    Unknown,
    Alive,
    Lost,
}

/// One entry of 1016h.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Consumer {
    word: u32,
    state: ConsumerState,
    deadline: Timer,
}

/// Change of the state of a monitored producer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HeartbeatEvent {
    Started { node: u8, recovered: bool },
    Lost { node: u8 },
}

impl Consumer {
    const NEW: Self = Self {
        word: 0,
        state: ConsumerState::Unknown,
        deadline: Timer::EXPIRED,
    };

    fn node(&self) -> u8 {
        (self.word >> 16) as u8
    }

    fn time_ms(&self) -> u16 {
        self.word as u16
    }

    fn active(&self) -> bool {
        matches!(self.node(), 1..=127) && self.time_ms() != 0
    }

    fn receive(&mut self, node: u8, state: u8) -> Option<HeartbeatEvent> {
        if !self.active() || self.node() != node {
            return None;
        }
        self.deadline = Timer::from_ms(self.time_ms());
        // A boot-up message is not a heartbeat: the producer restarts, and monitoring restarts with
        // its first heartbeat.
        if state == 0 {
            if self.state == ConsumerState::Alive {
                self.state = ConsumerState::Unknown;
            }
            return None;
        }
        let before = core::mem::replace(&mut self.state, ConsumerState::Alive);
        (before != ConsumerState::Alive).then_some(HeartbeatEvent::Started {
            node,
            recovered: before == ConsumerState::Lost,
        })
    }

    fn tick(&mut self) -> Option<HeartbeatEvent> {
        if !self.active() || self.state != ConsumerState::Alive || !self.deadline.is_expired() {
            return None;
        }
        self.state = ConsumerState::Lost;
        Some(HeartbeatEvent::Lost { node: self.node() })
    }
}

/// Object 1016h.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Consumers([Consumer; CONSUMERS]);

impl Consumers {
    pub const NEW: Self = Self([Consumer::NEW; CONSUMERS]);

    pub fn word(&self, sub: u8) -> Option<u32> {
        let at = usize::from(sub.checked_sub(1)?);
        self.0.get(at).map(|consumer| consumer.word)
    }

    /// Returns the node-ID if the consumer had lost its producer: the caller clears that error.
    pub fn configure(&mut self, sub: u8, word: u32) -> Result<Option<u8>, Abort> {
        let new = Consumer {
            word,
            ..Consumer::NEW
        };
        let at = usize::from(sub.wrapping_sub(1));
        let twice = new.active()
            && self.0.iter().enumerate().any(|(other, consumer)| {
                other != at && consumer.active() && consumer.node() == new.node()
            });
        if twice {
            return Err(Abort::Incompatible);
        }
        let consumer = self.0.get_mut(at).ok_or(Abort::NoSubIndex)?;
        let lost = (consumer.state == ConsumerState::Lost).then(|| consumer.node());
        *consumer = new;
        Ok(lost)
    }

    pub fn receive(&mut self, node: u8, state: u8) -> Option<HeartbeatEvent> {
        self.0
            .iter_mut()
            .find_map(|consumer| consumer.receive(node, state))
    }

    pub fn advance(&mut self, elapsed: Timer) {
        for consumer in &mut self.0 {
            consumer.deadline.advance(elapsed);
        }
    }

    /// Node-ID of the producer that consumer `at` monitors.
    pub fn node(&self, at: usize) -> Option<u8> {
        let consumer = self.0.get(at).filter(|consumer| consumer.active());
        consumer.map(Consumer::node)
    }

    /// The next loss not reported yet; call until it returns `None`.
    pub fn tick(&mut self) -> Option<HeartbeatEvent> {
        self.0.iter_mut().find_map(Consumer::tick)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn monitoring_starts_with_the_first_heartbeat() {
        let mut consumers = Consumers::NEW;
        assert_eq!(consumers.configure(1, 5 << 16 | 100), Ok(None));
        let started = |recovered| Some(HeartbeatEvent::Started { node: 5, recovered });
        let after = |consumers: &mut Consumers, time_us| {
            consumers.advance(Timer::from_us(time_us));
            consumers.tick()
        };
        assert_eq!(after(&mut consumers, 1_000_000), None);
        assert_eq!(consumers.receive(5, 0), None);
        assert_eq!(after(&mut consumers, 1_000_000), None);
        assert_eq!(consumers.receive(5, 5), started(false));
        assert_eq!(after(&mut consumers, 99_999), None);
        assert_eq!(
            after(&mut consumers, 1),
            Some(HeartbeatEvent::Lost { node: 5 })
        );
        assert_eq!(after(&mut consumers, 100_000), None);
        assert_eq!(consumers.receive(5, 127), started(true));
    }

    #[test]
    fn a_producer_is_monitored_by_one_consumer_only() {
        let mut consumers = Consumers::NEW;
        assert_eq!(consumers.configure(1, 5 << 16 | 100), Ok(None));
        assert_eq!(
            consumers.configure(2, 5 << 16 | 200),
            Err(Abort::Incompatible)
        );
        assert_eq!(
            consumers.configure(2, 5 << 16),
            Ok(None),
            "a consumer without a time is inactive"
        );
        assert_eq!(
            consumers.configure(1, 5 << 16 | 300),
            Ok(None),
            "an entry may be changed in place"
        );
    }
}
