//! CANopen frames to and from the board, which is node 1.

use virtual_board::can::Outcome;
use virtual_board::run::Finished;

use crate::frames::{BoardFrame, Frame, standard};

/// A frame of the board on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seen {
    /// Its end, ns.
    pub at_ns: u64,
    /// The frame.
    pub frame: Frame,
}

/// Every frame that the board got through.
pub fn seen<S>(finished: &Finished<S>) -> Vec<Seen> {
    let sent = finished.trace.frames.iter();
    let of_the_board = sent.filter(|sent| sent.sender == 0 && sent.outcome == Outcome::Delivered);
    of_the_board
        .map(|sent| Seen {
            at_ns: sent.at_ns,
            frame: Frame::from_the_wire(&sent.frame),
        })
        .collect()
}

/// A command of network management to the node.
pub fn nmt(command: u8) -> Frame {
    standard(0, &[command, 1])
}

/// The node's start.
pub fn start() -> Frame {
    nmt(1)
}

/// RPDO 1: controlword and target position, mdeg.
pub fn control(controlword: u16, mdeg: i32) -> Frame {
    let [a, b] = controlword.to_le_bytes();
    let [c, d, e, f] = mdeg.to_le_bytes();
    standard(0x201, &[a, b, c, d, e, f])
}

/// RPDO 2: target velocity, mdeg/s, and mode of operation.
pub fn target(mdeg_s: i32, mode: i8) -> Frame {
    let [a, b, c, d] = mdeg_s.to_le_bytes();
    standard(0x301, &[a, b, c, d, mode as u8])
}

/// An SDO request.
pub fn sdo(bytes: [u8; 8]) -> Frame {
    standard(0x601, &bytes)
}

/// An SDO request that writes so many bytes.
pub fn write(index: u16, sub: u8, value: u32, size: u8) -> Frame {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = value.to_le_bytes();
    let command = 0x23 | (4 - size.min(4)) << 2;
    sdo([command, low, high, sub, a, b, c, d])
}

/// An SDO request that reads.
pub fn read(index: u16, sub: u8) -> Frame {
    let [low, high] = index.to_le_bytes();
    sdo([0x40, low, high, sub, 0, 0, 0, 0])
}
