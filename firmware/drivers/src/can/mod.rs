//! The CAN controller: how it takes part in the bus, its queues, its acceptance list.
//!
//! [`CanPort`] is what differs between controllers. [`CanController`] joins the bus and transmits,
//! [`receive`] fetches received frames.

mod acceptance;
mod controller;

use canopen::CanFrame;
use embedded_can::{Error, ErrorKind};
pub use firmware::application::BusState;

pub use self::{
    acceptance::AcceptedIds,
    controller::{CanController, TransmitQueues},
};

/// Events on the bus since the last query.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Activity {
    /// Nothing.
    None,
    /// A valid frame.
    Frame,
    /// An error.
    Error,
}

/// How a controller takes part in the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// It receives, and neither acknowledges nor signals errors.
    Listening,
    /// It takes part.
    Full,
    /// It is not on the bus, and receives what it transmits.
    LoopBack,
}

/// Received frames were lost: the controller's FIFO was full.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Overrun;

impl Error for Overrun {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Overrun
    }
}

/// The registers of a controller. Nothing here waits.
pub trait CanPort {
    /// Its mailboxes for transmission, which transmit in the order in which they are filled.
    const MAILBOXES: usize;

    /// Whether a mailbox has no frame to transmit.
    fn is_free(&self, mailbox: usize) -> bool;

    /// Requests the transmission of a frame from a free mailbox.
    fn put(&mut self, mailbox: usize, frame: &CanFrame);

    /// Aborts the transmission from these mailboxes, one bit each; a frame on the bus is
    /// transmitted to its end.
    fn abort(&mut self, mailboxes: u32);

    /// Number of frames transmitted since the last call.
    fn take_transmitted(&mut self) -> u32;

    /// Takes the oldest received frame.
    fn receive(&mut self) -> Option<CanFrame>;

    /// Whether received frames were lost since the last call.
    fn take_overrun(&mut self) -> bool;

    /// Requests to leave the bus, which ends bus-off as well.
    fn leave(&mut self);

    /// Whether the controller has left the bus. It leaves at once or at the end of the frame that
    /// it transmits, unless its receive line is stuck.
    fn has_left(&self) -> bool;

    /// Joins the bus with this bit rate, kbit/s, after 11 recessive bits; called after it has left
    /// the bus.
    fn join(&mut self, kbit_s: u16, mode: Mode);

    /// Whether it is bus-off.
    fn is_off(&mut self) -> bool;

    /// Events since it joined the bus or since the last call that returned an error. A
    /// frame that no other station acknowledges is valid once its transmitter is error-passive.
    fn take_activity(&mut self) -> Activity;

    /// Its present state; acknowledges the interrupt of its changes.
    fn take_state(&mut self) -> BusState;
}

/// The next received frame, for the interrupt of the reception: first whether some were lost.
///
/// # Errors
/// [`Overrun`] once after frames were lost; `WouldBlock` without a further frame.
#[inline]
pub fn receive(port: &mut impl CanPort) -> nb::Result<CanFrame, Overrun> {
    if port.take_overrun() {
        return Err(nb::Error::Other(Overrun));
    }
    port.receive().ok_or(nb::Error::WouldBlock)
}
