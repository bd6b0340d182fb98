//! The node of an actuator.

use embedded_can::{ExtendedId, Frame, Id};

use crate::FrameId;
use crate::application::Application;
use crate::assembly::Assembly;
use crate::data_types::{ALLOCATION, ARRAY_COMMAND, DataType, received};
use crate::server::Server;

/// Settings of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// The node-ID, 1 to 125; 0 for one that the network allocates.
    pub node_id: u8,
    /// Period of the actuator's status, us; 0 for none.
    pub status_period_us: u32,
}

/// A node: frames go in and come out, commands and parameters go to its [`Application`].
#[derive(Debug)]
pub struct Node {
    assembly: Assembly,
    server: Server,
}

impl Node {
    /// A node that starts at this time.
    #[must_use]
    pub fn new(settings: Settings, app: &impl Application, now_us: u64) -> Self {
        Self {
            assembly: Assembly::new(),
            server: Server::new(settings, app, now_us),
        }
    }

    /// The node-ID; `None` while the network has not allocated one.
    #[must_use]
    pub const fn node_id(&self) -> Option<u8> {
        match self.server.node_id {
            0 => None,
            id => Some(id),
        }
    }

    /// What the node receives, for the acceptance filter of a controller: extended identifiers, and
    /// masks of the bits that must be equal.
    #[must_use]
    pub fn filters(&self) -> [(ExtendedId, u32); 3] {
        // Type and kind of a message; receiver and kind of a service.
        let message = |data_type: DataType| (u32::from(data_type.id) << 8, 0x00FF_FF80);
        let service = (u32::from(self.server.node_id) << 8 | 0x80, 0x0000_7F80);
        [message(ALLOCATION), message(ARRAY_COMMAND), service]
            .map(|(id, mask)| (ExtendedId::new(id).unwrap_or(ExtendedId::ZERO), mask))
    }

    /// Takes a frame from the bus.
    pub fn receive(&mut self, frame: &impl Frame, now_us: u64, app: &mut impl Application) {
        let Id::Extended(id) = frame.id() else { return };
        let Some(id) = FrameId::parse(id).filter(|_| frame.is_data_frame()) else {
            return;
        };
        let is_for_others = id
            .kind
            .receiver()
            .is_some_and(|to| to != self.server.node_id);
        if is_for_others {
            return;
        }
        let Some(data_type) = received(id.kind) else {
            return;
        };
        let transfer = self.assembly.receive(id, data_type, frame.data(), now_us);
        if let Some(transfer) = transfer {
            self.server.receive(&transfer, now_us, app);
        }
    }

    /// Does what is due. To be called some hundred times a second. Returns whether the node shall
    /// restart, once what it has sent is gone.
    pub fn tick(&mut self, now_us: u64, app: &mut impl Application) -> bool {
        self.server.tick(now_us, app)
    }

    /// The next frame for the bus.
    pub fn transmit<F: Frame>(&mut self) -> Option<F> {
        self.server.outbox.pop()
    }
}
