//! Heartbeat producer and consumer (CiA 301, 7.2.8.3.2).

use crate::Abort;
use crate::timer::Timer;

/// How many nodes can be watched; the dictionary says how many 1016h shows.
pub(crate) const CONSUMERS: usize = 8;

/// Object 1017h and when it is due.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Producer {
    period_ms: u16,
    due: Timer,
    pending: bool,
}

impl Producer {
    pub const NEW: Self = Self {
        period_ms: 0,
        due: Timer::OVER,
        pending: false,
    };

    pub fn period_ms(&self) -> u16 {
        self.period_ms
    }

    /// The first heartbeat under a new period goes out at once.
    pub fn set_period(&mut self, period_ms: u16) {
        self.period_ms = period_ms;
        self.due = Timer::ms(period_ms);
        self.pending = period_ms != 0;
    }

    /// After boot-up, which stands for the first heartbeat.
    pub fn restart(&mut self) {
        self.pending = false;
        self.due = Timer::ms(self.period_ms);
    }

    /// The state changed: the network learns it at once.
    pub fn announce(&mut self) {
        self.pending = self.period_ms != 0;
    }

    pub fn pass(&mut self, elapsed: Timer) {
        self.due.pass(elapsed);
    }

    pub fn tick(&mut self) {
        self.pending |= self.period_ms != 0 && self.due.repeats(Timer::ms(self.period_ms));
    }

    pub fn take(&mut self) -> bool {
        core::mem::take(&mut self.pending)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Watch {
    /// Not heard since it was configured, or since its boot-up.
    Unknown,
    Alive,
    Lost,
}

/// One entry of 1016h.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Consumer {
    word: u32,
    watch: Watch,
    deadline: Timer,
}

/// What a consumer noticed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Notice {
    Started { node: u8, recovered: bool },
    Lost { node: u8 },
}

impl Consumer {
    const NEW: Self = Self {
        word: 0,
        watch: Watch::Unknown,
        deadline: Timer::OVER,
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

    fn receive(&mut self, node: u8, state: u8) -> Option<Notice> {
        if !self.active() || self.node() != node {
            return None;
        }
        self.deadline = Timer::ms(self.time_ms());
        // A boot-up is no heartbeat: the producer starts anew, and so does watching it.
        if state == 0 {
            if self.watch == Watch::Alive {
                self.watch = Watch::Unknown;
            }
            return None;
        }
        let before = core::mem::replace(&mut self.watch, Watch::Alive);
        (before != Watch::Alive).then_some(Notice::Started {
            node,
            recovered: before == Watch::Lost,
        })
    }

    fn tick(&mut self) -> Option<Notice> {
        if !self.active() || self.watch != Watch::Alive || !self.deadline.is_over() {
            return None;
        }
        self.watch = Watch::Lost;
        Some(Notice::Lost { node: self.node() })
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

    /// Whether the consumer had lost its producer: its error goes with it.
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
        let lost = (consumer.watch == Watch::Lost).then(|| consumer.node());
        *consumer = new;
        Ok(lost)
    }

    pub fn receive(&mut self, node: u8, state: u8) -> Option<Notice> {
        self.0
            .iter_mut()
            .find_map(|consumer| consumer.receive(node, state))
    }

    pub fn pass(&mut self, elapsed: Timer) {
        for consumer in &mut self.0 {
            consumer.deadline.pass(elapsed);
        }
    }

    /// The node that is watched by one of the consumers.
    pub fn node(&self, at: usize) -> Option<u8> {
        let consumer = self.0.get(at).filter(|consumer| consumer.active());
        consumer.map(Consumer::node)
    }

    /// The first loss that was not yet told; call until there is none.
    pub fn tick(&mut self) -> Option<Notice> {
        self.0.iter_mut().find_map(Consumer::tick)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_is_watched_from_its_first_heartbeat_on() {
        let mut consumers = Consumers::NEW;
        assert_eq!(consumers.configure(1, 5 << 16 | 100), Ok(None));
        let started = |recovered| Some(Notice::Started { node: 5, recovered });
        let after = |consumers: &mut Consumers, time_us| {
            consumers.pass(Timer::us(time_us));
            consumers.tick()
        };
        assert_eq!(after(&mut consumers, 1_000_000), None);
        assert_eq!(consumers.receive(5, 0), None);
        assert_eq!(after(&mut consumers, 1_000_000), None);
        assert_eq!(consumers.receive(5, 5), started(false));
        assert_eq!(after(&mut consumers, 99_999), None);
        assert_eq!(after(&mut consumers, 1), Some(Notice::Lost { node: 5 }));
        assert_eq!(after(&mut consumers, 100_000), None);
        assert_eq!(consumers.receive(5, 127), started(true));
    }

    #[test]
    fn a_node_is_watched_once_only() {
        let mut consumers = Consumers::NEW;
        assert_eq!(consumers.configure(1, 5 << 16 | 100), Ok(None));
        assert_eq!(
            consumers.configure(2, 5 << 16 | 200),
            Err(Abort::Incompatible)
        );
        assert_eq!(
            consumers.configure(2, 5 << 16),
            Ok(None),
            "without a time it is not watched"
        );
        assert_eq!(
            consumers.configure(1, 5 << 16 | 300),
            Ok(None),
            "the same entry may change"
        );
    }
}
