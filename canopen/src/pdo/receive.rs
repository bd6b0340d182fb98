//! RPDO: from the bus into the object dictionary.

use super::Channel;
use crate::instant::later;
use crate::message::Message;

/// One RPDO.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rpdo {
    pub channel: Channel,
    /// Waits for SYNC.
    waiting: Option<[u8; 8]>,
    deadline_us: Option<u64>,
}

/// What became of a received PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Received {
    /// To be written to the objects now.
    Apply([u8; 8]),
    /// Will be, with the next SYNC.
    Waits,
    /// Shorter than what is mapped.
    TooShort,
}

impl Rpdo {
    pub const NEW: Self = Self {
        channel: Channel::NEW,
        waiting: None,
        deadline_us: None,
    };

    /// The node became OPERATIONAL, or the PDO exists only now.
    pub fn start(&mut self) {
        self.waiting = None;
        self.deadline_us = None;
    }

    pub fn receive(&mut self, message: &Message, now_us: u64) -> Received {
        if message.length < self.channel.map.length() {
            return Received::TooShort;
        }
        let timer = self.channel.event_us();
        self.deadline_us = (timer != 0).then(|| later(now_us, timer));
        if self.channel.synchronous() {
            self.waiting = Some(message.data);
            return Received::Waits;
        }
        Received::Apply(message.data)
    }

    /// What is to be written now that there was a SYNC.
    pub fn sync(&mut self) -> Option<[u8; 8]> {
        self.waiting.take()
    }

    /// Whether its event timer has just run out.
    pub fn timed_out(&mut self, now_us: u64) -> bool {
        let over = self.deadline_us.is_some_and(|deadline| now_us >= deadline);
        if over {
            self.deadline_us = None;
        }
        over
    }
}
