//! Plain CAN frames with standard identifiers; `n` is the node's number, all numbers little endian.
//!
//! | identifier | to | bytes | content |
//! |---|---|---|---|
//! | 0x200 + n | board | 5 | i32 commanded angle, mdeg; u8 request ([`Order`]) |
//! | 0x200 + n | board | 1 | u8 request |
//! | 0x300 + n | board | 8 | [`Access`]: u8 operation; u8 number; u16 index; u32 value |
//! | 0x380 + n | bus | 8 | its answer, in the same layout; bit 7 of the operation: refused |
//! | 0x180 + n | bus | 8 | i32 angle, mdeg; i16 rate, 0.1 deg/s; u8 state; u8 fault |
//! | 0x280 + n | bus | 8 | i16 current, mA; i16 back-EMF, mV; i16 duty, 0.01 %; u16 supply, mV |
//! | 0x480 + n | bus | 8 | u16 control period; i16 temperature, 0.01 deg C; u32 conditions present, bit n for fault n |
//!
//! Numbers beyond their field end at its ends. State and fault are the numbers of
//! [`BoardState`](crate::application::BoardState) and [`Fault`](crate::faults::Fault), 0 for no fault.
//!
//! The request of a command frame is served first. The angle is commanded only beside no request, 0,
//! and beside 1, enable: whoever acknowledges or saves does not mean to move the shaft.

use embedded_can::{Frame, Id, StandardId};
use model_core::control::units::{Angle, Percent};

use crate::{
    application::{CommandSource, Outputs, Request},
    timing::{angle_of_mdeg, thousandths},
};

mod access;
#[cfg(test)]
mod tests;

pub use access::{Access, Operation};

/// Base of the command frame's identifier.
pub const COMMAND: u16 = 0x200;
/// Base of the identifier of a frame that reads or writes one value.
pub const ACCESS: u16 = 0x300;
/// Base of the identifier of its answer.
pub const ANSWER: u16 = 0x380;
/// Bases of the telemetry frames' identifiers.
pub const TELEMETRY: [u16; 3] = [0x180, 0x280, 0x480];

/// What a command frame asks for beside its angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// 1 to 6: enable, disable, quick stop, acknowledge, commands from the bus, commands from the
    /// servo pulse; 10: end the excitation.
    Application(Request),
    /// 7: write the parameters into the flash.
    SaveParameters,
    /// 8: take the defaults; they are not saved.
    RestoreDefaults,
    /// 9: start the excitation that the settings mean. 10, to end it, is a request.
    StartExcitation,
    /// 11: start the capture that the settings mean.
    StartCapture,
    /// 12: end it.
    StopCapture,
}

impl Order {
    fn of(code: u8) -> Option<Self> {
        Some(Self::Application(match code {
            1 => Request::Enable,
            2 => Request::Disable,
            3 => Request::QuickStop,
            4 => Request::Acknowledge,
            5 => Request::Source(CommandSource::Bus),
            6 => Request::Source(CommandSource::ServoPulse),
            7 => return Some(Self::SaveParameters),
            8 => return Some(Self::RestoreDefaults),
            9 => return Some(Self::StartExcitation),
            10 => Request::StopExcitation,
            11 => return Some(Self::StartCapture),
            12 => return Some(Self::StopCapture),
            _ => return None,
        }))
    }
}

/// What a frame says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Message {
    /// A command frame.
    Command {
        /// What is to be done first.
        order: Option<Order>,
        /// The commanded angle, if one is.
        angle: Option<Angle>,
    },
    /// One value is to be read or written.
    Access(Access),
}

/// The frames of one node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frames {
    node_id: u16,
    malformed: u32,
}

impl Frames {
    /// The frames of this node; the number's low seven bits count.
    pub const fn new(node_id: u8) -> Self {
        Self {
            node_id: node_id as u16 & 0x7f,
            malformed: 0,
        }
    }

    /// The identifiers of the frames that are for this node, and whether of remote frames.
    ///
    /// ```
    /// # use embedded_can::{Id, StandardId};
    /// let wanted: Vec<_> = firmware::frames::Frames::new(5).identifiers().collect();
    /// let standard = |raw| Id::Standard(StandardId::new(raw).unwrap());
    /// assert_eq!(wanted, [(standard(0x205), false), (standard(0x305), false)]);
    /// ```
    pub fn identifiers(&self) -> impl Iterator<Item = (Id, bool)> {
        let of = |base| StandardId::new(base + self.node_id);
        let ids = [COMMAND, ACCESS].into_iter().filter_map(of);
        ids.map(|id| (Id::Standard(id), false))
    }

    /// Frames so far that were meant for this node and said nothing.
    pub fn malformed(&self) -> u32 {
        self.malformed
    }

    /// What a frame says; none where it is meant for others or is malformed.
    ///
    /// Malformed and counted: extended identifiers, remote frames, another length, an unknown
    /// request.
    pub fn receive(&mut self, frame: &impl Frame) -> Option<Message> {
        let message = match frame.id() {
            Id::Standard(id) if id.as_raw() == COMMAND + self.node_id => Self::command(frame),
            Id::Standard(id) if id.as_raw() == ACCESS + self.node_id => Self::access(frame),
            Id::Standard(_) => return None,
            Id::Extended(_) => None,
        };
        if message.is_none() {
            self.malformed = self.malformed.saturating_add(1);
        }
        message
    }

    fn command(frame: &impl Frame) -> Option<Message> {
        let (code, angle) = match *frame.data() {
            [code] => (code, None),
            [a, b, c, d, code] => (code, Some([a, b, c, d])),
            _ => return None,
        };
        if frame.is_remote_frame() {
            return None;
        }
        Some(Message::Command {
            order: match code {
                0 => None,
                code => Some(Order::of(code)?),
            },
            angle: angle
                .filter(|_| code <= 1)
                .map(|bytes| angle_of_mdeg(i32::from_le_bytes(bytes))),
        })
    }

    fn access(frame: &impl Frame) -> Option<Message> {
        let bytes = frame.data().try_into().ok()?;
        if frame.is_remote_frame() {
            return None;
        }
        Access::of_bytes(bytes).map(Message::Access)
    }

    /// The answer to an access.
    pub fn answer<F: Frame>(&self, access: Access, is_refused: bool) -> Option<F> {
        self.frame(ANSWER, &access.bytes(is_refused))
    }

    /// The telemetry of a control period.
    pub fn telemetry<F: Frame>(&self, outputs: &Outputs) -> [Option<F>; 3] {
        let t = &outputs.telemetry;
        let angle = thousandths(t.angle).to_le_bytes();
        let rate = narrow(thousandths(t.rate) / 100);
        let fault = outputs.fault.map_or(0, |fault| fault.number() as u8);
        let [p, q] = rate.to_le_bytes();
        let motion = [
            angle[0],
            angle[1],
            angle[2],
            angle[3],
            p,
            q,
            outputs.state as u8,
            fault,
        ];
        let duty = narrow(hundredths(t.duty));
        let supply = unsigned(t.supply_mv);
        let power = joined([
            narrow(t.current_ma).to_le_bytes(),
            narrow(t.back_emf_mv).to_le_bytes(),
            duty.to_le_bytes(),
            supply.to_le_bytes(),
        ]);
        let [w, x, y, z] = t.present.bits().to_le_bytes();
        let health = joined([
            (t.tick as u16).to_le_bytes(),
            narrow(t.temperature_mdeg_c / 10).to_le_bytes(),
            [w, x],
            [y, z],
        ]);
        let [first, second, third] = TELEMETRY;
        [
            self.frame(first, &motion),
            self.frame(second, &power),
            self.frame(third, &health),
        ]
    }

    fn frame<F: Frame>(&self, base: u16, data: &[u8]) -> Option<F> {
        F::new(StandardId::new(base + self.node_id)?, data)
    }
}

/// A share in 0.01 %.
fn hundredths(share: Percent) -> i32 {
    thousandths(share) / 10
}

fn narrow(value: i32) -> i16 {
    value.max(i32::from(i16::MIN)).min(i32::from(i16::MAX)) as i16
}

fn unsigned(value: i32) -> u16 {
    value.max(0).min(i32::from(u16::MAX)) as u16
}

fn joined([[a, b], [c, d], [e, f], [g, h]]: [[u8; 2]; 4]) -> [u8; 8] {
    [a, b, c, d, e, f, g, h]
}
