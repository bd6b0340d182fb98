//! Frames between the tests and the board, whose node is number 1.

use embedded_can::{Id, StandardId};
use virtual_board::can;

/// Orders of a command frame.
pub mod order {
    /// The angle alone.
    pub const NONE: u8 = 0;
    /// Switch the bridge on.
    pub const ENABLE: u8 = 1;
    /// Switch it off.
    pub const DISABLE: u8 = 2;
    /// Stop as fast as the motor can.
    pub const QUICK_STOP: u8 = 3;
    /// Acknowledge the fault.
    pub const ACKNOWLEDGE: u8 = 4;
    /// Commands from the bus.
    pub const SOURCE_BUS: u8 = 5;
    /// Commands from the servo pulse.
    pub const SOURCE_SERVO: u8 = 6;
    /// Save the parameters.
    pub const SAVE: u8 = 7;
}

/// A frame on the side of the application.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// Standard identifier.
    pub id: u16,
    /// Bytes of data.
    pub len: usize,
    /// The data, and zeros.
    pub data: [u8; 8],
}

impl embedded_can::Frame for Frame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        let Id::Standard(id) = id.into() else {
            return None;
        };
        let mut bytes = [0; 8];
        bytes.get_mut(..data.len())?.copy_from_slice(data);
        Some(Self {
            id: id.as_raw(),
            len: data.len(),
            data: bytes,
        })
    }

    fn new_remote(_: impl Into<Id>, _: usize) -> Option<Self> {
        None
    }

    fn is_extended(&self) -> bool {
        false
    }

    fn is_remote_frame(&self) -> bool {
        false
    }

    fn id(&self) -> Id {
        StandardId::new(self.id).unwrap_or(StandardId::ZERO).into()
    }

    fn dlc(&self) -> usize {
        self.len
    }

    fn data(&self) -> &[u8] {
        &self.data[..self.len]
    }
}

impl Frame {
    /// A command frame: an angle, mdeg, and an order.
    pub fn command(mdeg: i32, order: u8) -> Self {
        let [a, b, c, d] = mdeg.to_le_bytes();
        Self {
            id: 0x201,
            len: 5,
            data: [a, b, c, d, order, 0, 0, 0],
        }
    }

    /// A frame that writes a value by its number.
    pub fn write(number: u8, value: u32) -> Self {
        let [a, b, c, d] = value.to_le_bytes();
        Self {
            id: 0x301,
            len: 8,
            data: [1, number, 0, 0, a, b, c, d],
        }
    }

    /// The frame on the wire.
    pub fn on_the_wire(&self) -> can::Frame {
        can::Frame::data_frame(can::Id::Standard(self.id), &self.data[..self.len])
    }
}

impl From<&can::Frame> for Frame {
    fn from(frame: &can::Frame) -> Self {
        Self {
            id: frame.id.value() as u16,
            len: frame.payload().len(),
            data: frame.data,
        }
    }
}

/// The first telemetry frame of a control period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status {
    /// Angle, mdeg.
    pub mdeg: i32,
    /// State.
    pub state: u8,
    /// Fault.
    pub fault: u8,
}

impl Status {
    /// What the frame says, if it is that one.
    pub fn of(frame: &can::Frame) -> Option<Self> {
        let [a, b, c, d, _, _, state, fault] = frame.data;
        (frame.id.value() == 0x181).then_some(Self {
            mdeg: i32::from_le_bytes([a, b, c, d]),
            state,
            fault,
        })
    }
}
