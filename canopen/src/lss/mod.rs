//! Layer setting services (CiA 305): node-ID and bit rate over the bus.

mod activation;
mod configuration;
mod selection;

use core::task::Poll;

use crate::application::{Application, BitRate};
use crate::nmt::NodeId;
use crate::timer::Timer;
use activation::Activation;
use selection::Selection;

/// CAN-IDs of the LSS master's requests and the slave's responses.
pub(crate) use crate::cob_id::{LSS_REQUEST as REQUEST, LSS_RESPONSE as RESPONSE};

/// Identity object 1018h: vendor-ID, product code, revision number, serial number.
pub(crate) type Identity = [u32; 4];

type Data = [u8; 8];

/// LSS slave.
#[derive(Debug)]
pub(crate) struct LssSlave {
    configuring: bool,
    selection: Selection,
    /// Pending node-ID: takes effect with the next reset communication.
    node_id: Option<NodeId>,
    bit_rate: Option<BitRate>,
    activation: Option<Activation>,
    storing: bool,
    reply: Option<Data>,
}

/// Action of the node required by a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    Nothing,
    /// Report the new node-ID to the application.
    NodeIdChanged,
    /// Boot up: a node without a node-ID now has one.
    BootUp,
}

impl LssSlave {
    pub const fn new(node_id: Option<NodeId>) -> Self {
        Self {
            configuring: false,
            selection: Selection::new(),
            node_id,
            bit_rate: None,
            activation: None,
            storing: false,
            reply: None,
        }
    }

    /// Pending node-ID, which takes effect with the next reset communication.
    pub const fn node_id(&self) -> Option<NodeId> {
        self.node_id
    }

    /// `active` is the node-ID in use.
    pub fn receive(
        &mut self,
        request: Data,
        identity: Identity,
        active: Option<NodeId>,
        app: &mut impl Application,
    ) -> Outcome {
        let number = u32::from_le_bytes([request[1], request[2], request[3], request[4]]);
        match request[0] {
            0x04 => return self.switch_global(request[1], active),
            0x40..=0x43 => self.switch_selective(request[0] - 0x40, number, identity),
            0x46..=0x4B => self.identify_remote_slave(request[0] - 0x46, number, identity),
            0x4C if active.is_none() && self.node_id.is_none() => self.answer(0x50, 0),
            0x51 if active.is_none() && self.node_id.is_none() && !self.configuring => {
                self.fast_scan(&request, number, identity);
            }
            _ if self.configuring => {
                return self.configure(&request, identity, active, app);
            }
            _ => {}
        }
        Outcome::Nothing
    }

    fn switch_selective(&mut self, part: u8, number: u32, identity: Identity) {
        if self.selection.select(part, number, identity) {
            self.configuring = true;
            self.answer(0x44, 0);
        }
    }

    fn identify_remote_slave(&mut self, part: u8, number: u32, identity: Identity) {
        if self.selection.identify(part, number, identity) {
            self.answer(0x4F, 0);
        }
    }

    fn switch_global(&mut self, mode: u8, active: Option<NodeId>) -> Outcome {
        let leaves = self.configuring && mode == 0;
        match mode {
            0 => self.configuring = false,
            1 => self.configuring = true,
            _ => {}
        }
        self.selection = Selection::new();
        if leaves && active.is_none() && self.node_id.is_some() {
            return Outcome::BootUp;
        }
        Outcome::Nothing
    }

    fn fast_scan(&mut self, request: &Data, number: u32, identity: Identity) {
        let [.., bit, sub, next] = *request;
        let Some(found) = self.selection.fast_scan(number, bit, sub, next, identity) else {
            return;
        };
        self.configuring = found;
        self.answer(0x4F, 0);
    }

    /// Sets the response to the master: command and up to four bytes.
    fn answer(&mut self, command: u8, value: u32) {
        let [a, b, c, d] = value.to_le_bytes();
        self.reply = Some([command, a, b, c, d, 0, 0, 0]);
    }

    pub fn advance(&mut self, elapsed: Timer) {
        if let Some(activation) = &mut self.activation {
            activation.advance(elapsed);
        }
    }

    pub fn tick(&mut self, app: &mut impl Application) {
        if self.storing
            && let Poll::Ready(done) = app.store_lss(self.node_id, self.bit_rate)
        {
            self.storing = false;
            self.answer(0x17, configuration::error_code(done));
        }
        if let Some(activation) = &mut self.activation
            && activation.advance_phase(app)
        {
            self.activation = None;
        }
    }

    /// Whether transmission is inhibited by a bit rate switch.
    pub const fn silent(&self) -> bool {
        self.activation.is_some()
    }

    pub fn transmit(&mut self) -> Option<Data> {
        self.reply.take()
    }
}
