//! Which frames concern the node.

use embedded_can::Id;

use super::Node;
use crate::lss;
use crate::message::bus_id;

/// Network management: node-ID 0, function code 0 (CiA 301, 7.3.3).
const NMT: u32 = 0;

/// The most identifiers that [`Node::identifiers`] gives, beside one for each PDO.
pub const SERVICE_IDENTIFIERS: usize = 5 + crate::heartbeat::CONSUMERS;

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
        let services = &self.services;
        let data = |id| (id, false);
        let own = self.node_id.map(|id| 0x600 + u32::from(id.get()));
        let fixed = [
            Some(lss::REQUEST),
            own.map(|_| NMT),
            own,
            services.sync.identifier(),
            services.time.identifier(),
        ];
        let heartbeats = services.consumers.nodes();
        let heartbeats = heartbeats.map(|node| 0x700 + u32::from(node));
        let rpdos = services.rpdos.iter().map(|rpdo| &rpdo.channel);
        let rpdos = rpdos.filter(|channel| channel.valid());
        let tpdos = services.tpdos.iter().map(|tpdo| &tpdo.channel);
        let tpdos = tpdos.filter(|channel| channel.remote_allowed());
        (fixed.into_iter().flatten().map(data))
            .chain(heartbeats.map(data))
            .chain(rpdos.map(|channel| (channel.id(), false)))
            .chain(tpdos.map(|channel| (channel.id(), true)))
            .filter_map(|(id, remote)| Some((bus_id(id)?, remote)))
    }
}
