//! The CAN identifiers that the node receives.

use embedded_can::Id;

use super::Node;
use crate::cob_id;
use crate::lss;
use crate::message::bus_id;
use crate::pdo::PdoParameters;

/// Network management: node-ID 0, function code 0 (CiA 301, 7.3.3).
const NMT: u32 = 0;

/// Number of identifiers of LSS, NMT, SDO, SYNC and TIME.
const FIXED: usize = 5;

/// Maximum number of identifiers of [`Node::identifiers`], not counting one for each PDO.
pub const SERVICE_IDENTIFIERS: usize = FIXED + crate::heartbeat::CONSUMERS;

impl<const R: usize, const T: usize> Node<R, T> {
    /// The identifiers that the node receives at present, each with whether it is received as a
    /// remote frame, for the acceptance filter of a CAN controller. They change with a write to a
    /// communication parameter, a reset and a new node-ID.
    ///
    /// ```
    /// # use canopen::{Abort, Application, Dictionary, Node, NodeId, dictionary::Entry};
    /// # struct Nothing;
    /// # impl Application for Nothing {
    /// #     fn read(&mut self, _: &Entry) -> Result<u64, Abort> { Err(Abort::NoObject) }
    /// #     fn write(&mut self, _: &Entry, _: u64) -> Result<(), Abort> { Err(Abort::NoObject) }
    /// # }
    /// # const EMPTY: Dictionary = match Dictionary::try_new(&[], &[], &[]) { Ok(it) => it, Err(_) => panic!() };
    /// use embedded_can::{Id, StandardId};
    /// let node = Node::<0, 0>::new(&EMPTY, NodeId::new(5), &mut Nothing, 0);
    /// let sdo = Id::Standard(StandardId::new(0x605).unwrap());
    /// assert!(node.identifiers().any(|accepted| accepted == (sdo, false)));
    /// ```
    pub fn identifiers(&self) -> impl Iterator<Item = (Id, bool)> + '_ {
        let positions = 0..SERVICE_IDENTIFIERS + R + T;
        positions.filter_map(|position| {
            let (id, remote) = self.identifier(position)?;
            Some((bus_id(id)?, remote))
        })
    }

    /// Whether the node transmits process data with this identifier: a controller with frames that
    /// wait too long may discard these, and these only; [`Node::repeat_process_data`] replaces
    /// them.
    #[must_use]
    pub fn is_process_data(&self, id: Id) -> bool {
        let mut tpdos = self.services.pdo_table.transmit().iter();
        tpdos.any(|tpdo| tpdo.valid() && bus_id(tpdo.id()) == Some(id))
    }

    /// Whether this is the identifier of the SYNC frames that the node consumes.
    #[must_use]
    pub fn is_sync(&self, id: Id) -> bool {
        self.services.sync.identifier().and_then(bus_id) == Some(id)
    }

    /// Whether the node transmits emergencies with this identifier.
    #[must_use]
    pub fn is_emergency(&self, id: Id) -> bool {
        bus_id(self.services.emergency.identifier()) == Some(id)
    }

    /// The identifier at a position of the list, if it exists at present, and whether it is
    /// received as a remote frame.
    fn identifier(&self, position: usize) -> Option<(u32, bool)> {
        let services = &self.services;
        let own = self
            .node_id
            .map(|id| cob_id::SDO_REQUEST + u32::from(id.get()));
        let consumer = position.wrapping_sub(FIXED);
        let rpdo = position.wrapping_sub(SERVICE_IDENTIFIERS);
        let id = match position {
            0 => Some(lss::REQUEST),
            1 => own.map(|_| NMT),
            2 => own,
            3 => services.sync.identifier(),
            4 => services.time.identifier(),
            _ => {
                let node = services.consumers.node(consumer);
                let heartbeat = node.map(|node| cob_id::HEARTBEAT + u32::from(node));
                let rpdo = services.pdo_table.receive().get(rpdo);
                let received = rpdo.filter(|parameters| parameters.valid());
                heartbeat.or(received.map(PdoParameters::id))
            }
        };
        if let Some(id) = id {
            return Some((id, false));
        }
        let tpdo = services.pdo_table.transmit().get(rpdo.wrapping_sub(R))?;
        tpdo.remote_allowed().then(|| (tpdo.id(), true))
    }
}
