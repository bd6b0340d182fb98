//! Frames between the tests and the board, whose node is number 1.

pub use canopen::CanFrame as Frame;
use embedded_can::StandardId;
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

/// What the tests say to the board, and hear from it.
pub trait BoardFrame: Sized {
    /// A command frame: an angle, mdeg, and an order.
    fn command(mdeg: i32, order: u8) -> Self;

    /// A frame that writes a value by its number.
    fn write(number: u8, value: u32) -> Self;

    /// A frame that asks for a value by its number.
    fn read(number: u8) -> Self;

    /// The frame on the wire.
    fn on_the_wire(&self) -> can::Frame;

    /// A frame from the wire.
    fn from_the_wire(frame: &can::Frame) -> Self;
}

/// A data frame with an identifier of 11 bits.
///
/// # Panics
/// If the identifier has more, or there are more than 8 bytes.
pub fn standard(id: u16, data: &[u8]) -> Frame {
    let id = StandardId::new(id).expect("11 bits");
    embedded_can::Frame::new(id, data).expect("at most 8 bytes")
}

impl BoardFrame for Frame {
    fn command(mdeg: i32, order: u8) -> Self {
        let [a, b, c, d] = mdeg.to_le_bytes();
        standard(0x201, &[a, b, c, d, order])
    }

    fn write(number: u8, value: u32) -> Self {
        let [a, b, c, d] = value.to_le_bytes();
        standard(0x301, &[1, number, 0, 0, a, b, c, d])
    }

    fn read(number: u8) -> Self {
        standard(0x301, &[0, number, 0, 0, 0, 0, 0, 0])
    }

    fn on_the_wire(&self) -> can::Frame {
        let id = match self.raw_id() {
            (id, true) => can::Id::Extended(id),
            (id, false) => can::Id::Standard(id as u16),
        };
        can::Frame::data_frame(id, embedded_can::Frame::data(self))
    }

    fn from_the_wire(frame: &can::Frame) -> Self {
        standard(frame.id.value() as u16, frame.payload())
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
