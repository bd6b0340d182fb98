//! Heartbeat producer and consumer (CiA 301, 7.2.8.3.2).

use crate::Abort;
use crate::instant::later;

/// How many nodes can be watched; the dictionary says how many 1016h shows.
pub(crate) const CONSUMERS: usize = 8;

/// Object 1017h and when it is due.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Producer {
    period_ms: u16,
    due_us: u64,
    pending: bool,
}

impl Producer {
    pub const NEW: Self = Self {
        period_ms: 0,
        due_us: 0,
        pending: false,
    };

    pub fn period_ms(&self) -> u16 {
        self.period_ms
    }

    /// The first heartbeat under a new period goes out at once.
    pub fn set_period(&mut self, period_ms: u16, now_us: u64) {
        self.period_ms = period_ms;
        self.due_us = later(now_us, self.period_us());
        self.pending = period_ms != 0;
    }

    /// After boot-up, which stands for the first heartbeat.
    pub fn restart(&mut self, now_us: u64) {
        self.pending = false;
        self.due_us = later(now_us, self.period_us());
    }

    /// The state changed: the network learns it at once.
    pub fn announce(&mut self) {
        self.pending = self.period_ms != 0;
    }

    pub fn tick(&mut self, now_us: u64) {
        if self.period_ms == 0 || now_us < self.due_us {
            return;
        }
        self.pending = true;
        self.due_us = next_on_grid(self.due_us, self.period_us(), now_us);
    }

    pub fn take(&mut self) -> bool {
        core::mem::take(&mut self.pending)
    }

    fn period_us(&self) -> u64 {
        u64::from(self.period_ms) * 1000
    }
}

/// The next point of a grid, or one period from now where more than one was missed.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn next_on_grid(due_us: u64, period_us: u64, now_us: u64) -> u64 {
    let next = later(due_us, period_us);
    if next > now_us {
        next
    } else {
        later(now_us, period_us)
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
    deadline_us: u64,
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
        deadline_us: 0,
    };

    fn node(&self) -> u8 {
        (self.word >> 16) as u8
    }

    fn time_us(&self) -> u64 {
        u64::from(self.word & 0xFFFF) * 1000
    }

    fn active(&self) -> bool {
        matches!(self.node(), 1..=127) && self.time_us() != 0
    }

    fn receive(&mut self, node: u8, state: u8, now_us: u64) -> Option<Notice> {
        if !self.active() || self.node() != node {
            return None;
        }
        self.deadline_us = later(now_us, self.time_us());
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

    fn tick(&mut self, now_us: u64) -> Option<Notice> {
        if !self.active() || self.watch != Watch::Alive || now_us < self.deadline_us {
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

    pub fn receive(&mut self, node: u8, state: u8, now_us: u64) -> Option<Notice> {
        self.0
            .iter_mut()
            .find_map(|consumer| consumer.receive(node, state, now_us))
    }

    /// The node that is watched by one of the consumers.
    pub fn node(&self, at: usize) -> Option<u8> {
        let consumer = self.0.get(at).filter(|consumer| consumer.active());
        consumer.map(Consumer::node)
    }

    /// The first loss that was not yet told; call until there is none.
    pub fn tick(&mut self, now_us: u64) -> Option<Notice> {
        self.0.iter_mut().find_map(|consumer| consumer.tick(now_us))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_does_not_drift_and_does_not_catch_up() {
        assert_eq!(next_on_grid(100, 10, 103), 110);
        assert_eq!(next_on_grid(100, 10, 137), 147);
        assert_eq!(next_on_grid(u64::MAX, 10, u64::MAX), u64::MAX);
    }

    #[test]
    fn a_node_is_watched_from_its_first_heartbeat_on() {
        let mut consumers = Consumers::NEW;
        assert_eq!(consumers.configure(1, 5 << 16 | 100), Ok(None));
        assert_eq!(consumers.tick(1_000_000), None);
        assert_eq!(consumers.receive(5, 0, 0), None);
        assert_eq!(consumers.tick(1_000_000), None);
        assert_eq!(
            consumers.receive(5, 5, 0),
            Some(Notice::Started {
                node: 5,
                recovered: false
            })
        );
        assert_eq!(consumers.tick(99_999), None);
        assert_eq!(consumers.tick(100_000), Some(Notice::Lost { node: 5 }));
        assert_eq!(consumers.tick(200_000), None);
        assert_eq!(
            consumers.receive(5, 127, 300_000),
            Some(Notice::Started {
                node: 5,
                recovered: true
            })
        );
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
