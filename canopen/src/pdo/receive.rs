//! Receive PDO.

use super::PdoParameters;
use crate::message::Message;
use crate::timer::Timer;

/// One RPDO.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rpdo {
    /// Data that wait for the next SYNC.
    buffered: Option<[u8; 8]>,
    deadline: Option<Timer>,
}

/// Result of the reception of a PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Received {
    /// Write the data to the mapped objects now.
    Apply([u8; 8]),
    /// The data are buffered until the next SYNC.
    Buffered,
    /// The frame is shorter than the mapping.
    TooShort,
}

impl Rpdo {
    pub const NEW: Self = Self {
        buffered: None,
        deadline: None,
    };

    /// Restarts the PDO: the node entered OPERATIONAL or the PDO became valid.
    pub fn start(&mut self) {
        self.buffered = None;
        self.deadline = None;
    }

    pub fn receive(&mut self, parameters: &PdoParameters, message: &Message) -> Received {
        if message.length < parameters.map.length() {
            return Received::TooShort;
        }
        let time_ms = parameters.event_ms;
        self.deadline = (time_ms != 0).then(|| Timer::from_ms(time_ms));
        if parameters.synchronous() {
            self.buffered = Some(message.data);
            return Received::Buffered;
        }
        Received::Apply(message.data)
    }

    /// Data to write to the mapped objects on a SYNC.
    pub fn sync(&mut self) -> Option<[u8; 8]> {
        self.buffered.take()
    }

    pub fn advance(&mut self, elapsed: Timer) {
        if let Some(deadline) = &mut self.deadline {
            deadline.advance(elapsed);
        }
    }

    /// Returns true once when the event timer expires.
    pub fn timed_out(&mut self) -> bool {
        let over = self.deadline.is_some_and(Timer::is_expired);
        if over {
            self.deadline = None;
        }
        over
    }
}
