//! The CAN bus between a client and the emulated board, in virtual time.

use std::io;
use std::time::Duration;

use canopen::CanFrame;
use embedded_can::Frame as _;
use host_sim::can::link::Link;
use virtual_board::can::{Frame, Id};
use virtual_board::run::ClientSide;

/// The bus of the emulated board.
#[derive(Debug)]
pub(super) struct VirtualLink(pub ClientSide);

impl Link for VirtualLink {
    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        self.0.send(to_wire(frame))
    }

    /// Frames that the client does not have are skipped.
    fn receive(&mut self, timeout: Duration) -> io::Result<Option<CanFrame>> {
        let frame = self.0.receive(timeout)?;
        Ok(frame.as_ref().and_then(from_wire))
    }

    fn pause(&mut self, time: Duration) -> io::Result<()> {
        self.0.pause(time)
    }
}

fn to_wire(frame: &CanFrame) -> Frame {
    let id = match frame.raw_id() {
        (id, true) => Id::Extended(id),
        (id, false) => Id::Standard(id as u16),
    };
    Frame::data_frame(id, frame.data())
}

fn from_wire(frame: &Frame) -> Option<CanFrame> {
    let is_extended = matches!(frame.id, Id::Extended(_));
    let length = frame.payload().len() as u8;
    CanFrame::raw(frame.id.value(), is_extended, false, length, frame.data)
}
