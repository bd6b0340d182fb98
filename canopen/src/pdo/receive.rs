//! RPDO: from the bus into the object dictionary.

use super::Channel;
use crate::message::Message;
use crate::timer::Timer;

/// One RPDO.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rpdo {
    pub channel: Channel,
    /// Waits for SYNC.
    waiting: Option<[u8; 8]>,
    deadline: Option<Timer>,
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
        deadline: None,
    };

    /// The node became OPERATIONAL, or the PDO exists only now.
    pub fn start(&mut self) {
        self.waiting = None;
        self.deadline = None;
    }

    pub fn receive(&mut self, message: &Message) -> Received {
        if message.length < self.channel.map.length() {
            return Received::TooShort;
        }
        let time_ms = self.channel.event_ms;
        self.deadline = (time_ms != 0).then(|| Timer::ms(time_ms));
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

    pub fn pass(&mut self, elapsed: Timer) {
        if let Some(deadline) = &mut self.deadline {
            deadline.pass(elapsed);
        }
    }

    /// Whether its event timer has just run out.
    pub fn timed_out(&mut self) -> bool {
        let over = self.deadline.is_some_and(Timer::is_over);
        if over {
            self.deadline = None;
        }
        over
    }
}
