//! Which frames concern the node.

use embedded_can::Id;

use super::Node;
use crate::lss;
use crate::message::bus_id;
use crate::pdo::Channel;

/// Network management: node-ID 0, function code 0 (CiA 301, 7.3.3).
const NMT: u32 = 0;

/// Those of LSS, NMT, SDO, SYNC and TIME.
const FIXED: usize = 5;

/// The most identifiers that [`Node::identifiers`] gives, beside one for each PDO.
pub const SERVICE_IDENTIFIERS: usize = FIXED + crate::heartbeat::CONSUMERS;

impl<const R: usize, const T: usize> Node<R, T> {
    /// The identifiers of the frames that concern the node at present, and whether of remote frames: a CAN
    /// controller may filter by them. They change with a write to a communication parameter, a reset, and a new
    /// node-ID.
    ///
    /// ```
    /// # use canopen::{Abort, Application, Dictionary, Node, NodeId, dictionary::Address};
    /// # struct Nothing;
    /// # impl Application for Nothing {
    /// #     fn read(&mut self, _: Address) -> Result<u64, Abort> { Err(Abort::NoObject) }
    /// #     fn write(&mut self, _: Address, _: u64) -> Result<(), Abort> { Err(Abort::NoObject) }
    /// # }
    /// # const EMPTY: Dictionary = match canopen::dictionary!(&[], &[], &[]) { Ok(it) => it, Err(_) => panic!() };
    /// use embedded_can::{Id, StandardId};
    /// let node = Node::<0, 0>::new(&EMPTY, NodeId::new(5), &mut Nothing, 0);
    /// let sdo = Id::Standard(StandardId::new(0x605).unwrap());
    /// assert!(node.identifiers().any(|wanted| wanted == (sdo, false)));
    /// ```
    pub fn identifiers(&self) -> impl Iterator<Item = (Id, bool)> + '_ {
        let places = 0..SERVICE_IDENTIFIERS + R + T;
        places.filter_map(|place| {
            let (id, remote) = self.identifier(place)?;
            Some((bus_id(id)?, remote))
        })
    }

    /// The identifier at one of so many places, if there is one at present, and whether of remote frames.
    fn identifier(&self, place: usize) -> Option<(u32, bool)> {
        let services = &self.services;
        let own = self.node_id.map(|id| 0x600 + u32::from(id.get()));
        let consumer = place.wrapping_sub(FIXED);
        let rpdo = place.wrapping_sub(SERVICE_IDENTIFIERS);
        let id = match place {
            0 => Some(lss::REQUEST),
            1 => own.map(|_| NMT),
            2 => own,
            3 => services.sync.identifier(),
            4 => services.time.identifier(),
            _ => {
                let node = services.consumers.node(consumer);
                let heartbeat = node.map(|node| 0x700 + u32::from(node));
                let rpdo = services.rpdos.get(rpdo).map(|rpdo| &rpdo.channel);
                let received = rpdo.filter(|channel| channel.valid());
                heartbeat.or(received.map(Channel::id))
            }
        };
        if let Some(id) = id {
            return Some((id, false));
        }
        let tpdo = services.tpdos.get(rpdo.wrapping_sub(R))?;
        let asked = tpdo.channel.remote_allowed();
        asked.then(|| (tpdo.channel.id(), true))
    }
}
