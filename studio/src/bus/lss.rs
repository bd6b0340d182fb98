//! An LSS master (CiA 305): finds a device without a node-ID by fast scan and assigns one.

use std::time::Duration;

use canopen::{
    CanFrame,
    cob_id::{LSS_REQUEST, LSS_RESPONSE, of_node},
};
use host_sim::can::{client::ClientError, link::Link};

/// Time for a response, which a device gives at once.
const PATIENCE: Duration = Duration::from_millis(50);

/// Time in which a device stores its configuration.
const STORE_PATIENCE: Duration = Duration::from_secs(5);

/// The four numbers of object 1018h.
pub type Identity = [u32; 4];

/// An LSS master.
pub struct LssMaster<'a> {
    link: &'a mut dyn Link,
}

impl<'a> LssMaster<'a> {
    /// A master on this bus.
    pub fn new(link: &'a mut dyn Link) -> Self {
        Self { link }
    }

    fn send(&mut self, data: [u8; 8]) -> Result<(), ClientError> {
        let id = of_node(LSS_REQUEST, 0);
        Ok(self
            .link
            .send(&CanFrame::received(id.into(), false, 8, data))?)
    }

    /// The response with this command, if one comes in time.
    fn response(&mut self, command: u8, time: Duration) -> Result<Option<[u8; 8]>, ClientError> {
        while let Some(frame) = self.link.receive(time)? {
            let data = frame.bytes();
            if frame.raw_id() == (LSS_RESPONSE, false) && data[0] == command {
                return Ok(Some(data));
            }
        }
        Ok(None)
    }

    /// One step of a fast scan; whether a device answers.
    fn step(&mut self, number: u32, bit: u8, sub: u8, next: u8) -> Result<bool, ClientError> {
        let [a, b, c, d] = number.to_le_bytes();
        self.send([0x51, a, b, c, d, bit, sub, next])?;
        Ok(self.response(0x4F, PATIENCE)?.is_some())
    }

    /// The identity of a device without a node-ID, which then is in the state of configuration;
    /// `None` if no device responds.
    ///
    /// # Errors
    /// Those of the bus.
    pub fn find(&mut self) -> Result<Option<Identity>, ClientError> {
        if !self.step(0, 0x80, 0, 0)? {
            return Ok(None);
        }
        let mut identity = [0; 4];
        for sub in 0..4 {
            let number = &mut identity[usize::from(sub)];
            for bit in (0..32).rev() {
                // No answer: the bit is set in every device that is left.
                if !self.step(*number, bit, sub, sub)? {
                    *number |= 1 << bit;
                }
            }
            let next = (sub + 1) % 4;
            if !self.step(*number, 0, sub, next)? {
                return Ok(None);
            }
        }
        Ok(Some(identity))
    }

    /// Assigns this node-ID to the device in the configuration state, stores it, and starts the
    /// device.
    ///
    /// # Errors
    /// Those of the bus, and [`ClientError::NotNow`] if the device refuses.
    pub fn assign(&mut self, node: u8) -> Result<(), ClientError> {
        let refused = |why| ClientError::NotNow { node, why };
        self.send([0x11, node, 0, 0, 0, 0, 0, 0])?;
        match self.response(0x11, PATIENCE)? {
            Some([_, 0, ..]) => {}
            Some(_) => return Err(refused("the device refuses this node-ID")),
            None => return Err(refused("the device does not answer")),
        }
        self.send([0x17, 0, 0, 0, 0, 0, 0, 0])?;
        let is_stored = matches!(self.response(0x17, STORE_PATIENCE)?, Some([_, 0, ..]));
        self.leave()?;
        match is_stored {
            true => Ok(()),
            false => Err(refused(
                "the device has taken the node-ID but has not stored it",
            )),
        }
    }

    /// Ends the state of configuration of all devices.
    ///
    /// # Errors
    /// Those of the bus.
    pub fn leave(&mut self) -> Result<(), ClientError> {
        self.send([0x04, 0, 0, 0, 0, 0, 0, 0])
    }
}
