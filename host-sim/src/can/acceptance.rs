//! The acceptance filter of a native actuator, as that of a board's CAN controller: on a bus of
//! many actuators most frames concern none of them.

use canopen::CanFrame;
use embedded_can::Id;
use firmware::drive::Device;

/// Number of the identifiers of 11 bits, as words of a bit each.
const WORDS: usize = (1 << 11) / 64;

/// The frames that an actuator receives: a bit for each identifier of 11 bits, and all of 29 bits,
/// which one with CANopen ignores.
#[derive(Debug, Clone)]
pub struct Acceptance([u64; WORDS]);

impl Acceptance {
    /// The frames that this device receives at present.
    pub fn of(device: &Device<'_>) -> Self {
        let mut words = [0; WORDS];
        if device.dronecan().is_none() {
            for (id, _) in device.node().identifiers() {
                if let Id::Standard(id) = id {
                    let id = id.as_raw();
                    words[usize::from(id / 64)] |= 1 << (id % 64);
                }
            }
        }
        Self(words)
    }

    /// Whether the frame is received.
    pub fn accepts(&self, frame: &CanFrame) -> bool {
        match frame.raw_id() {
            (_, true) => true,
            (id, false) => self.0[id as usize / 64] >> (id % 64) & 1 != 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use canopen::{CanFrame, NodeId};

    use crate::can::native_node::{CAPTURE_VALUES, NativeNode};

    #[test]
    fn a_new_identifier_of_an_rpdo_is_received_at_once_and_the_old_one_no_longer() {
        let mut buffer = vec![0; CAPTURE_VALUES];
        let node = NativeNode::new(1, NodeId::new(1), &Default::default(), &mut buffer);
        let mut node = node.expect("a node");
        let frame = |id, data| CanFrame::raw(id, false, false, 8, data).expect("a frame");
        let rpdo = |id| frame(id, [0; 8]);
        // The boot-up.
        while node.transmit().is_some() {}
        assert!(node.receive(&rpdo(0x201)) && !node.receive(&rpdo(0x210)));
        // 1400h:1 changes while the PDO is not valid.
        for id in [0x8000_0201_u32, 0x210] {
            let [a, b, c, d] = id.to_le_bytes();
            assert!(node.receive(&frame(0x601, [0x23, 0x00, 0x14, 1, a, b, c, d])));
            let answer = node.transmit().expect("an answer");
            let is_done = embedded_can::Frame::data(&answer).starts_with(&[0x60, 0x00, 0x14, 1]);
            assert!(is_done, "{answer:?}");
        }
        assert!(node.receive(&rpdo(0x210)));
        // Of other nodes.
        assert!(!node.receive(&rpdo(0x202)) && !node.receive(&frame(0x602, [0; 8])));
        node.step(4000);
        assert!(!node.receive(&rpdo(0x201)));
    }
}
