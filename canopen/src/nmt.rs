//! Network management (CiA 301, 7.2.8).

use core::num::NonZeroU8;

/// NMT state of a node; the discriminant is the value in its heartbeat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum NmtState {
    /// Initialisation: the boot-up message is not sent yet, or the node has no node-ID.
    Initialising = 0x00,
    /// Stopped: only NMT, heartbeat and LSS are active.
    Stopped = 0x04,
    /// Operational: all services are active.
    Operational = 0x05,
    /// Pre-operational: all services except PDOs are active.
    PreOperational = 0x7F,
}

impl NmtState {
    /// Whether SDO, SYNC, TIME and EMCY are active.
    pub(crate) const fn communicates(self) -> bool {
        matches!(self, Self::Operational | Self::PreOperational)
    }
}

/// Node-ID from 1 to 127.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct NodeId(NonZeroU8);

impl NodeId {
    /// `None` outside 1 to 127.
    ///
    /// ```
    /// use canopen::NodeId;
    /// assert_eq!(NodeId::new(127).map(NodeId::get), Some(127));
    /// assert_eq!(NodeId::new(0), None);
    /// assert_eq!(NodeId::new(128), None);
    /// ```
    #[must_use]
    pub const fn new(id: u8) -> Option<Self> {
        match NonZeroU8::new(id) {
            Some(id) if id.get() <= 127 => Some(Self(id)),
            _ => None,
        }
    }

    /// The node-ID as a number.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0.get()
    }
}

/// NMT command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Command {
    Enter(NmtState),
    ResetNode,
    ResetCommunication,
}

/// The command of an NMT message addressed to this node. Bytes behind the two of the standard,
/// which some masters send, mean nothing.
pub(crate) fn command(data: &[u8], node_id: NodeId) -> Option<Command> {
    let [specifier, node, ..] = data else {
        return None;
    };
    if *node != 0 && *node != node_id.get() {
        return None;
    }
    Some(match specifier {
        1 => Command::Enter(NmtState::Operational),
        2 => Command::Enter(NmtState::Stopped),
        128 => Command::Enter(NmtState::PreOperational),
        129 => Command::ResetNode,
        130 => Command::ResetCommunication,
        _ => return None,
    })
}
