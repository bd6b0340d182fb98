//! The bus of one native actuator, whose time goes on while its client waits.

use std::io;
use std::time::Duration;

use canopen::CanFrame;

use super::link::Link;
use super::native_node::NativeNode;

/// The bus of one native actuator.
pub struct NativeLink {
    node: NativeNode<'static>,
    after: Box<dyn FnMut(&mut NativeNode<'static>) + Send>,
}

impl NativeLink {
    /// A bus of this node. `after` is called after each control period.
    pub fn new(
        node: NativeNode<'static>,
        after: impl FnMut(&mut NativeNode<'static>) + Send + 'static,
    ) -> Self {
        let after = Box::new(after);
        Self { node, after }
    }

    fn step(&mut self) {
        self.node.step(self.node.next_us());
        (self.after)(&mut self.node);
    }

    /// The end of a time from now, us.
    fn end_us(&self, time: Duration) -> u64 {
        let us = u64::try_from(time.as_micros()).unwrap_or(u64::MAX);
        self.node.next_us().saturating_add(us)
    }
}

impl Link for NativeLink {
    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        self.node.receive(frame);
        Ok(())
    }

    fn receive(&mut self, timeout: Duration) -> io::Result<Option<CanFrame>> {
        let end_us = self.end_us(timeout);
        loop {
            let frame = self.node.transmit();
            if frame.is_some() || self.node.next_us() > end_us {
                return Ok(frame);
            }
            self.step();
        }
    }

    /// Discards the frames of the node.
    fn pause(&mut self, time: Duration) -> io::Result<()> {
        let end_us = self.end_us(time);
        while self.node.next_us() < end_us {
            self.step();
            while self.node.transmit().is_some() {}
        }
        Ok(())
    }
}
