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

/// The master's frames, and the answers.
pub(crate) const REQUEST: u32 = 0x7E5;
pub(crate) const RESPONSE: u32 = 0x7E4;

/// Vendor-ID, product code, revision and serial number: object 1018h.
pub(crate) type Identity = [u32; 4];

type Data = [u8; 8];

/// The slave.
#[derive(Debug)]
pub(crate) struct Server {
    configuring: bool,
    selection: Selection,
    /// The node-ID from the next reset of communication on.
    node_id: Option<NodeId>,
    bit_rate: Option<BitRate>,
    activation: Option<Activation>,
    storing: bool,
    reply: Option<Data>,
}

/// What the node has to do after a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    Nothing,
    /// Tell the application of a new node-ID.
    NodeIdChanged,
    /// The node had no node-ID, has one now, and boots.
    Start,
}

impl Server {
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

    /// The node-ID that the next reset of communication takes.
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
            0x40..=0x43 => {
                if self.selection.select(request[0] - 0x40, number, identity) {
                    self.configuring = true;
                    self.answer(0x44, 0);
                }
            }
            0x46..=0x4B => {
                if self.selection.identify(request[0] - 0x46, number, identity) {
                    self.answer(0x4F, 0);
                }
            }
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

    fn switch_global(&mut self, mode: u8, active: Option<NodeId>) -> Outcome {
        let leaves = self.configuring && mode == 0;
        match mode {
            0 => self.configuring = false,
            1 => self.configuring = true,
            _ => {}
        }
        self.selection = Selection::new();
        if leaves && active.is_none() && self.node_id.is_some() {
            return Outcome::Start;
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

    /// The next frame to the master; what stands behind the command has up to four bytes.
    #[cfg_attr(target_os = "none", inline(never))]
    fn answer(&mut self, command: u8, value: u32) {
        let [a, b, c, d] = value.to_le_bytes();
        self.reply = Some([command, a, b, c, d, 0, 0, 0]);
    }

    pub fn pass(&mut self, elapsed: Timer) {
        if let Some(activation) = &mut self.activation {
            activation.pass(elapsed);
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
            && activation.over(app)
        {
            self.activation = None;
        }
    }

    /// Whether nothing may be sent, as the bit rate of the network changes.
    pub const fn silent(&self) -> bool {
        self.activation.is_some()
    }

    pub fn transmit(&mut self) -> Option<Data> {
        self.reply.take()
    }
}
