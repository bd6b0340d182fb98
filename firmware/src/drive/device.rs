//! Node and drive together.

use canopen::dictionary::Address;
use canopen::{BusEvent, Node, NodeId};
use embedded_can::Frame;

use super::{Drive, Set, emergency};
use crate::{
    application::{BusState, Outputs, Samples, Start},
    dictionary::DICTIONARY,
    faults::FaultSet,
};

/// RPDOs of the dictionary.
pub const RPDOS: usize = 4;
/// TPDOs of the dictionary.
pub const TPDOS: usize = 4;

/// An actuator on a CAN bus: frames and samples go in, frames and the bridge's state come out.
#[derive(Debug)]
pub struct Device<'a> {
    node: Node<RPDOS, TPDOS>,
    /// The drive.
    pub drive: Drive<'a>,
    told: FaultSet,
    /// The bus is off, and the node knows.
    is_off: bool,
    /// Control periods without trouble on the bus; none once that was told.
    calm: Option<u16>,
    /// The worst since it was told, once there is one.
    worst_bus: Option<BusState>,
    /// The statusword that the node knows of.
    statusword: u16,
    /// Frames from the bus that it knows to be lost.
    receive_overflows: u32,
}

impl<'a> Device<'a> {
    /// Powers it on with what was stored; the node-ID is that of the stored parameters, or of who says another.
    ///
    /// ```
    /// use canopen::CanFrame;
    /// use firmware::{application::Start, drive::{Device, Set}};
    ///
    /// let mut buffer = [0; 80];
    /// let mut device = Device::new(Set::defaults(), Start::default(), &mut buffer, 0);
    /// let boot_up = device.transmit::<CanFrame>().unwrap();
    /// assert_eq!(boot_up.raw_id(), (0x701, false));
    /// ```
    pub fn new(stored: Set, start: Start, buffer: &'a mut [i32], now_us: u64) -> Self {
        let node_id = NodeId::new(stored.board.bus.node_id as u8);
        Self::with_node_id(stored, start, buffer, now_us, node_id)
    }

    /// As [`Device::new`], with this node-ID, or none to wait for LSS.
    pub fn with_node_id(
        stored: Set,
        start: Start,
        buffer: &'a mut [i32],
        now_us: u64,
        node_id: Option<NodeId>,
    ) -> Self {
        let mut drive = Drive::new(stored, start, buffer);
        let node = Node::new(&DICTIONARY, node_id, &mut drive, now_us);
        Self {
            node,
            drive,
            told: FaultSet::EMPTY,
            is_off: false,
            calm: None,
            worst_bus: None,
            statusword: 0,
            receive_overflows: 0,
        }
    }

    /// The node.
    pub fn node(&self) -> &Node<RPDOS, TPDOS> {
        &self.node
    }

    /// Takes a frame from the bus.
    pub fn receive(&mut self, frame: &impl Frame, now_us: u64) {
        self.tell_node_id();
        self.node.receive(frame, now_us, &mut self.drive);
    }

    /// The next frame for the bus, if there is one.
    pub fn transmit<F: Frame>(&mut self) -> Option<F> {
        self.node.transmit(&mut self.drive)
    }

    /// One control period, at its time: [`Device::control`], then [`Device::communicate`].
    pub fn step(&mut self, samples: &Samples, now_us: u64) -> Outputs {
        let outputs = self.control(samples);
        self.communicate(now_us);
        outputs
    }

    /// One control period of the drive alone; the network learns of it with the next [`Device::communicate`].
    pub fn control(&mut self, samples: &Samples) -> Outputs {
        let before = self.worst_bus.unwrap_or(samples.bus);
        self.worst_bus = Some(worse(before, samples.bus));
        self.drive.step(samples)
    }

    /// Does what has become due on the network; at least once in a control period.
    pub fn communicate(&mut self, now_us: u64) {
        self.tell_faults();
        self.tell_bus();
        let statusword = self.drive.statusword();
        if self.statusword != statusword {
            self.statusword = statusword;
            self.node.object_changed(Address::new(0x6041, 0));
        }
        self.tell_node_id();
        self.node.tick(now_us, &mut self.drive);
        self.drive.application.prepare();
    }

    /// What is stored of identifiers is stored without the node-ID in them.
    fn tell_node_id(&mut self) {
        self.drive.node_id = self.node.node_id().map_or(0, NodeId::get);
    }

    /// An EMCY for each fault that is new, and one for each that is gone.
    fn tell_faults(&mut self) {
        let latched = self.drive.latched();
        let tick = self.drive.application().telemetry().tick;
        for fault in self.told.without(latched).iter() {
            let code = emergency::code(fault);
            self.node.clear(code, emergency::instance(fault));
        }
        for fault in latched.without(self.told).iter() {
            let error = emergency::of(fault, tick);
            self.node.raise(error, &mut self.drive);
        }
        self.told = latched;
    }

    /// Trouble on the bus is told as long as it lasts: the node sends an EMCY for what it does not know yet, also after a
    /// reset of its own. That it is gone is told once there was none for a while, or a bus that fails again and again would
    /// be full of it.
    fn tell_bus(&mut self) {
        let Some(state) = self.worst_bus.take() else {
            return;
        };
        let lost = self.drive.diagnostics.receive_overflows;
        let was_off = core::mem::replace(&mut self.is_off, state == BusState::Off);
        let events = [
            (state == BusState::Off).then_some(BusEvent::BusOff),
            (was_off && !self.is_off).then_some(BusEvent::BusOffRecovered),
            (state == BusState::Passive).then_some(BusEvent::ErrorPassive),
            (lost != self.receive_overflows).then_some(BusEvent::Overrun),
        ];
        self.receive_overflows = lost;
        for event in events.into_iter().flatten() {
            self.calm = Some(0);
            self.node.bus_event(event, &mut self.drive);
        }
        self.calm = match self.calm {
            Some(CALM) => {
                self.node.bus_event(BusEvent::Recovered, &mut self.drive);
                None
            }
            calm => calm.map(|periods| periods + 1),
        };
    }
}

/// Control periods without trouble after which it is gone: a second.
const CALM: u16 = 250;

/// The worse of two states.
fn worse(a: BusState, b: BusState) -> BusState {
    if a as u8 > b as u8 { a } else { b }
}
