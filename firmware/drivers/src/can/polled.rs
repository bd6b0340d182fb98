//! A port as the trait of embedded-can.

use canopen::CanFrame;
use embedded_can::nb::Can;

use super::{CanPort, Overrun, receive};

/// A port as `embedded_can::nb::Can`: for programs that poll, as those that test a board. A program
/// with interrupts and queues has a [`super::CanController`].
#[derive(Debug)]
pub struct NbCan<P>(pub P);

impl<P: CanPort> Can for NbCan<P> {
    type Frame = CanFrame;
    type Error = Overrun;

    /// Transmits from the first free mailbox. It replaces no frame that waits: they are transmitted
    /// in their order.
    fn transmit(&mut self, frame: &CanFrame) -> nb::Result<Option<CanFrame>, Overrun> {
        let free = (0..P::MAILBOXES).find(|mailbox| self.0.is_free(*mailbox));
        self.0.put(free.ok_or(nb::Error::WouldBlock)?, frame);
        Ok(None)
    }

    fn receive(&mut self) -> nb::Result<CanFrame, Overrun> {
        receive(&mut self.0)
    }
}
