//! LSS services of the configuration state.

use super::{Activation, Data, Identity, LssSlave, Outcome};
use crate::Abort;
use crate::application::{Application, BitRate};
use crate::nmt::NodeId;

/// Node-ID value "not configured".
const UNCONFIGURED: u8 = 0xFF;

/// Error code of a refusal for a reason of the device.
const IMPLEMENTATION_SPECIFIC: u32 = 0xFF;

impl LssSlave {
    pub(super) fn configure(
        &mut self,
        request: &Data,
        identity: Identity,
        active: Option<NodeId>,
        app: &mut impl Application,
    ) -> Outcome {
        let [command, first, second, ..] = *request;
        // A node without a node-ID has no other service by which it could be unlocked.
        let is_locked = active.is_some() && app.guarded();
        match command {
            0x11 | 0x13 if is_locked => self.answer(command, IMPLEMENTATION_SPECIFIC),
            0x11 => return self.set_node_id(first),
            0x13 => self.set_bit_rate(first, second, app),
            0x15 => {
                let delay_ms = u16::from_le_bytes([first, second]);
                self.activation = self
                    .bit_rate
                    .map(|bit_rate| Activation::new(bit_rate, delay_ms));
            }
            0x17 => self.storing = true,
            0x5A..=0x5D => {
                let number = identity
                    .get(usize::from(command - 0x5A))
                    .copied()
                    .unwrap_or(0);
                self.answer(command, number);
            }
            0x5E => {
                let id = active.map_or(UNCONFIGURED, NodeId::get);
                self.answer(command, u32::from(id));
            }
            _ => {}
        }
        Outcome::Nothing
    }

    fn set_node_id(&mut self, id: u8) -> Outcome {
        let new = NodeId::new(id);
        if new.is_none() && id != UNCONFIGURED {
            self.answer(0x11, 1);
            return Outcome::Nothing;
        }
        self.answer(0x11, 0);
        self.node_id = new;
        Outcome::NodeIdChanged
    }

    fn set_bit_rate(&mut self, table: u8, index: u8, app: &impl Application) {
        let bit_rate = (table == 0).then(|| from_index(index)).flatten();
        match bit_rate.filter(|bit_rate| app.supports_bit_rate(*bit_rate)) {
            Some(bit_rate) => {
                self.bit_rate = Some(bit_rate);
                self.answer(0x13, 0);
            }
            None => self.answer(0x13, 1),
        }
    }
}

/// Error code of the response to "store configuration".
pub(super) fn error_code(done: Result<(), Abort>) -> u32 {
    match done {
        Ok(()) => 0,
        Err(Abort::UnsupportedAccess) => 1,
        Err(_) => 2,
    }
}

/// Bit timing table 0; index 5 is reserved.
const fn from_index(index: u8) -> Option<BitRate> {
    Some(match index {
        0 => BitRate::Kbit1000,
        1 => BitRate::Kbit800,
        2 => BitRate::Kbit500,
        3 => BitRate::Kbit250,
        4 => BitRate::Kbit125,
        6 => BitRate::Kbit50,
        7 => BitRate::Kbit20,
        8 => BitRate::Kbit10,
        9 => BitRate::Automatic,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bit_timing_table_0_is_that_of_cia_305() {
        use BitRate::{Automatic, Kbit10, Kbit20, Kbit50, Kbit125};
        use BitRate::{Kbit250, Kbit500, Kbit800, Kbit1000};
        let rates = [Kbit1000, Kbit800, Kbit500, Kbit250, Kbit125].map(Some);
        assert_eq!([0, 1, 2, 3, 4].map(from_index), rates);
        assert_eq!(from_index(5), None, "reserved");
        let rates = [Kbit50, Kbit20, Kbit10, Automatic].map(Some);
        assert_eq!([6, 7, 8, 9].map(from_index), rates);
        assert_eq!(from_index(10), None);
    }

    #[test]
    fn a_missing_memory_is_not_a_failing_one() {
        assert_eq!(error_code(Ok(())), 0);
        assert_eq!(error_code(Err(Abort::UnsupportedAccess)), 1);
        assert_eq!(error_code(Err(Abort::Hardware)), 2);
    }
}
