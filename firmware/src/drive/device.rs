//! The node on the bus, CANopen or DroneCAN, and the drive together.

use canopen::dictionary::Address;
use canopen::{BusEvent, Node, NodeId};
use embedded_can::Frame;

use super::{Drive, StoredParameters, emergency};
use crate::{
    application::{BusState, Outputs},
    dictionary::DICTIONARY,
    health::Warning,
};

/// RPDOs of the dictionary.
pub const RPDOS: usize = 4;
/// TPDOs of the dictionary.
pub const TPDOS: usize = 4;

/// The communication of an actuator on a CAN bus: frames and outputs of the control loop go in,
/// frames and messages to the loop come out.
#[derive(Debug)]
pub struct Device<'a> {
    node: Node<RPDOS, TPDOS>,
    /// The node on the bus in place of the former.
    dronecan: Option<dronecan::Node>,
    /// The drive.
    pub drive: Drive<'a>,
    /// The node was informed that the bus is off.
    is_bus_off: bool,
    /// Control periods since the last bus error; `None` after the recovery was reported.
    error_free_periods: Option<u16>,
    /// The worst state of the bus since the last report.
    worst_bus: Option<BusState>,
    /// The statusword of the last TPDO check.
    statusword: u16,
    /// The warnings of the health that were reported last.
    warnings: u8,
    /// Lost frames that were reported.
    receive_overflows: u32,
}

impl<'a> Device<'a> {
    /// Powers the device on with these stored parameters, the node-ID among them.
    ///
    /// ```
    /// use canopen::CanFrame;
    /// use firmware::drive::{Device, StoredParameters};
    ///
    /// let mut buffer = [0; 80];
    /// let mut device = Device::new(StoredParameters::DEFAULT, &mut buffer, 0);
    /// let boot_up = device.transmit::<CanFrame>().unwrap();
    /// assert_eq!(boot_up.raw_id(), (0x701, false));
    /// ```
    pub fn new(stored: StoredParameters, buffer: &'a mut [i32], now_us: u64) -> Self {
        let node_id = NodeId::new(stored.board.bus.node_id as u8);
        Self::with_node_id(stored, buffer, now_us, node_id)
    }

    /// As [`Device::new`], with this node-ID; `None` waits for LSS.
    // Not inlined: its temporaries, as large as the device, stay out of the caller's stack frame.
    #[inline(never)]
    pub fn with_node_id(
        stored: StoredParameters,
        buffer: &'a mut [i32],
        now_us: u64,
        node_id: Option<NodeId>,
    ) -> Self {
        let mut drive = Drive::new(stored, buffer);
        let node = Node::new(&DICTIONARY, node_id, &mut drive, now_us);
        let dronecan = (stored.has_dronecan()).then(|| drive.start_dronecan(now_us));
        Self {
            node,
            dronecan,
            drive,
            is_bus_off: false,
            error_free_periods: None,
            worst_bus: None,
            statusword: 0,
            warnings: 0,
            receive_overflows: 0,
        }
    }

    /// The CANopen node.
    pub fn node(&self) -> &Node<RPDOS, TPDOS> {
        &self.node
    }

    /// The DroneCAN node, if that is the one on the bus.
    pub fn dronecan(&self) -> Option<&dronecan::Node> {
        self.dronecan.as_ref()
    }

    /// Takes a frame from the bus.
    pub fn receive(&mut self, frame: &impl Frame, now_us: u64) {
        if let Some(node) = &mut self.dronecan {
            return node.receive(frame, now_us, &mut self.drive);
        }
        self.update_node_id();
        self.drive.has_queued = false;
        self.node.receive(frame, now_us, &mut self.drive);
    }

    /// The next frame for the bus, if there is one.
    pub fn transmit<F: Frame>(&mut self) -> Option<F> {
        match &mut self.dronecan {
            Some(node) => node.transmit(),
            None => self.node.transmit(&mut self.drive),
        }
    }

    /// Frames with process data were discarded because they had waited for the bus too long: those
    /// that no SYNC requests are sampled anew with the next [`Device::communicate`].
    pub fn repeat_process_data(&mut self) {
        self.node.repeat_process_data();
    }

    /// Takes the outputs of a control period; the next [`Device::communicate`] reports them to the
    /// network.
    pub fn observe(&mut self, outputs: &Outputs) {
        let bus = outputs.telemetry.bus;
        let before = self.worst_bus.unwrap_or(bus);
        self.worst_bus = Some(worse(before, bus));
        self.drive.observe(outputs);
    }

    /// Does what is due on the network. To be called at least once in a control period.
    pub fn communicate(&mut self, now_us: u64) {
        if let Some(node) = &mut self.dronecan {
            self.drive.install_if_asked();
            if node.tick(now_us, &mut self.drive) {
                self.drive.power_on();
                *node = self.drive.start_dronecan(now_us);
            }
            return;
        }
        self.report_faults();
        self.report_health();
        self.report_bus();
        let statusword = self.drive.statusword();
        if self.statusword != statusword {
            self.statusword = statusword;
            self.node.object_changed(Address::new(0x6041, 0));
        }
        self.update_node_id();
        self.drive.has_queued = false;
        self.node.tick(now_us, &mut self.drive);
        self.drive.prepare_sample();
    }

    /// The drive needs the node-ID because COB-IDs are stored without it.
    fn update_node_id(&mut self) {
        self.drive.node_id = self.node.node_id().map_or(0, NodeId::get);
    }

    /// Sends an EMCY for each new fault, and one for each fault that has ended.
    fn report_faults(&mut self) {
        let latched = self.drive.latched();
        let tick = self.drive.outputs().telemetry.tick;
        for fault in self.drive.reported.without(latched).iter() {
            let code = emergency::code(fault);
            self.node.clear(code, emergency::instance(fault));
        }
        for fault in latched.without(self.drive.reported).iter() {
            let error = emergency::of(fault, tick);
            self.node.raise(error, &mut self.drive);
        }
        self.drive.reported = latched;
    }

    /// Sends an EMCY for each warning of the health, and one for each that has ended.
    fn report_health(&mut self) {
        let warnings = self.drive.health.warnings();
        let changed = core::mem::replace(&mut self.warnings, warnings) ^ warnings;
        if changed == 0 {
            return;
        }
        for warning in Warning::ALL
            .into_iter()
            .filter(|it| changed & it.bit() != 0)
        {
            let error = emergency::of_warning(warning);
            if warnings & warning.bit() == 0 {
                self.node.clear(error.code, error.instance);
            } else {
                self.node.raise(error, &mut self.drive);
            }
        }
    }

    /// Passes bus errors to the node again and again while they are active: the node sends an EMCY
    /// for each one that it has not reported, also after its own reset. The recovery is reported
    /// after a second without errors, or a bus with recurring errors would be flooded.
    fn report_bus(&mut self) {
        let Some(state) = self.worst_bus.take() else {
            return;
        };
        let lost = self.drive.diagnostics.receive_overflows;
        let was_off = core::mem::replace(&mut self.is_bus_off, state == BusState::Off);
        let events = [
            (state == BusState::Off).then_some(BusEvent::BusOff),
            (was_off && !self.is_bus_off).then_some(BusEvent::BusOffRecovered),
            (state == BusState::Passive).then_some(BusEvent::ErrorPassive),
            (lost != self.receive_overflows).then_some(BusEvent::Overrun),
        ];
        self.receive_overflows = lost;
        for event in events.into_iter().flatten() {
            self.error_free_periods = Some(0);
            self.node.bus_event(event, &mut self.drive);
        }
        self.error_free_periods = match self.error_free_periods {
            Some(RECOVERY_PERIODS) => {
                self.node.bus_event(BusEvent::Recovered, &mut self.drive);
                None
            }
            periods => periods.map(|periods| periods + 1),
        };
    }
}

/// Control periods without errors after which the bus has recovered: a second.
const RECOVERY_PERIODS: u16 = model_core::time::CONTROL_RATE_HZ as u16;

/// The worse of two states.
fn worse(a: BusState, b: BusState) -> BusState {
    if a as u8 > b as u8 { a } else { b }
}
