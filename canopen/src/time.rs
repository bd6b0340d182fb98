//! TIME consumer (CiA 301, 7.2.6).

use crate::Abort;
use crate::application::TimeOfDay;
use crate::message::{IDENTIFIER, Message, cob_id_change_allowed};

/// TIME consumer with object 1012h.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimeConsumer {
    cob_id: u32,
}

/// Bit 31 of 1012h: the node consumes TIME. Bit 30: the node produces TIME.
const CONSUME: u32 = 1 << 31;
const PRODUCE: u32 = 1 << 30;

impl TimeConsumer {
    pub const NEW: Self = Self { cob_id: 0 };

    /// Identifier of the consumed TIME frames.
    pub fn identifier(&self) -> Option<u32> {
        (self.cob_id & CONSUME != 0).then_some(self.cob_id & IDENTIFIER)
    }

    pub fn receive(&self, message: &Message) -> Option<TimeOfDay> {
        if message.remote || self.identifier() != Some(message.id) {
            return None;
        }
        let [a, b, c, d, e, f] = message.payload() else {
            return None;
        };
        Some(TimeOfDay {
            milliseconds: u32::from_le_bytes([*a, *b, *c, *d]) & 0x0FFF_FFFF,
            days: u16::from_le_bytes([*e, *f]),
        })
    }

    pub fn cob_id(&self) -> u32 {
        self.cob_id
    }

    pub fn set_cob_id(&mut self, new: u32) -> Result<(), Abort> {
        let in_use = new & self.cob_id & CONSUME != 0;
        if new & PRODUCE != 0 || !cob_id_change_allowed(new, self.cob_id, in_use) {
            return Err(Abort::Value);
        }
        self.cob_id = new;
        Ok(())
    }
}
