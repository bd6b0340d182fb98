//! An actuator that runs natively: the firmware's application and its device on the bus around the
//! plant.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use canopen::{CanFrame, NodeId};
use firmware::{
    actuator::Actuator,
    application::{BusState, Start},
    drive::StoredParameters,
    native::{bridge, samples},
    store::{self, Flash, Page, Progress, Saver, Status},
};
use model_core::{
    parameter::ParameterError,
    plant::board::{BoardPlant, BoardPlantOptions, Defects, EncoderWire, SampledBoardPlant, Stuck},
};

use super::acceptance::Acceptance;
use super::node_fault::{BusFaults, Change};

/// Length of a control period, us.
pub const PERIOD_US: u64 = model_core::time::CONTROL_PERIOD_US as u64;

/// Values in the capture buffer, as on the board.
pub const CAPTURE_VALUES: usize = 45_056;

/// Words of a flash page: 16 KiB.
const PAGE_WORDS: usize = 4_096;

/// Flash in memory, which completes every operation at once.
struct Memory([Vec<u32>; 2]);

impl Memory {
    fn erased() -> Self {
        Self([vec![u32::MAX; PAGE_WORDS], vec![u32::MAX; PAGE_WORDS]])
    }
}

impl Flash for Memory {
    const ROW: usize = 1;
    const PAGE_BYTES: u32 = 4 * PAGE_WORDS as u32;

    fn start_erase(&mut self, page: Page) {
        self.0[page as usize].fill(u32::MAX);
    }

    fn start_program(&mut self, page: Page, offset: u16, row: &[u32]) {
        let places = self.0[page as usize]
            .iter_mut()
            .skip(usize::from(offset / 4));
        for (place, word) in places.zip(row) {
            *place &= word;
        }
    }

    fn status(&mut self) -> Status {
        Status::Ready
    }

    fn read(&self, page: Page, offset: u16) -> u32 {
        let page = &self.0[page as usize];
        page.get(usize::from(offset / 4))
            .copied()
            .unwrap_or(u32::MAX)
    }
}

/// One actuator.
pub struct NativeNode<'a> {
    actuator: Actuator<'a>,
    plant: SampledBoardPlant,
    flash: Memory,
    saver: Saver<StoredParameters>,
    next_us: u64,
    skipped_us: u64,
    encoder_switch: Arc<AtomicBool>,
    faults: BusFaults,
    acceptance: Acceptance,
    /// Whether a frame or a control period may have changed what the node receives.
    is_acceptance_old: bool,
}

impl<'a> NativeNode<'a> {
    /// An actuator with default parameters, this serial number and node-ID (`None` waits for LSS),
    /// and this capture buffer.
    ///
    /// # Errors
    /// For a parameter of the plant that is out of range.
    pub fn new(
        serial_number: u32,
        node_id: Option<NodeId>,
        options: &BoardPlantOptions,
        buffer: &'a mut [i32],
    ) -> Result<Self, ParameterError> {
        let mut set = StoredParameters::DEFAULT;
        if let Some(id) = node_id {
            set.board.bus.node_id = i32::from(id.get());
        }
        Self::of(set, serial_number, node_id, options, buffer)
    }

    /// As [`NativeNode::new`], with DroneCAN: the actuator of this number, which is its serial
    /// number too.
    ///
    /// # Errors
    /// For a parameter of the plant that is out of range.
    pub fn with_dronecan(
        number: u8,
        options: &BoardPlantOptions,
        buffer: &'a mut [i32],
    ) -> Result<Self, ParameterError> {
        let set = StoredParameters::DEFAULT.with_dronecan(number);
        Self::of(set, number.into(), None, options, buffer)
    }

    fn of(
        set: StoredParameters,
        serial_number: u32,
        node_id: Option<NodeId>,
        options: &BoardPlantOptions,
        buffer: &'a mut [i32],
    ) -> Result<Self, ParameterError> {
        let flash = Memory::erased();
        let loaded = store::load::<StoredParameters>(&flash);
        let mut actuator = Actuator::with_node_id(set, Start::default(), buffer, 0, node_id);
        actuator.device.drive.diagnostics.serial_number = serial_number;
        Ok(Self {
            acceptance: Acceptance::of(&actuator.device),
            is_acceptance_old: false,
            actuator,
            plant: SampledBoardPlant::new(BoardPlant::try_new(options)?, &mut |_, _| {}),
            saver: Saver::new(&loaded),
            flash,
            next_us: PERIOD_US,
            skipped_us: 0,
            encoder_switch: Arc::default(),
            faults: BusFaults::default(),
        })
    }

    /// With a switch that breaks a wire of the encoder while it is set.
    pub fn with_encoder_switch(self, encoder_switch: Arc<AtomicBool>) -> Self {
        Self {
            encoder_switch,
            ..self
        }
    }

    /// Receives a frame, at the time of the node's last control period; returns whether the frame
    /// concerns the node, which may then have frames to transmit.
    pub fn receive(&mut self, frame: &CanFrame) -> bool {
        if self.faults.is_off || !self.accepts(frame) {
            return false;
        }
        self.actuator.receive(frame, self.now_us());
        self.is_acceptance_old = true;
        true
    }

    fn accepts(&mut self, frame: &CanFrame) -> bool {
        // The node itself ignores what an old filter accepts.
        if !self.acceptance.accepts(frame) && std::mem::take(&mut self.is_acceptance_old) {
            self.acceptance = Acceptance::of(&self.actuator.device);
        }
        self.acceptance.accepts(frame)
    }

    /// The next frame for the bus.
    pub fn transmit(&mut self) -> Option<CanFrame> {
        let now_us = self.now_us();
        if let Some(frame) = self.faults.due(now_us) {
            return Some(frame);
        }
        while let Some(frame) = self.actuator.transmit() {
            if let Some(frame) = self.faults.pass(frame, now_us) {
                return Some(frame);
            }
        }
        None
    }

    /// Runs a control period if one is due; returns whether it did.
    pub fn step(&mut self, now_us: u64) -> bool {
        if now_us < self.next_us {
            return false;
        }
        let is_broken = self.encoder_switch.load(Relaxed) || self.faults.is_encoder_lost;
        self.plant.plant.defects.encoder_wire =
            is_broken.then_some((EncoderWire::Data, Stuck::High));
        let mut samples = samples(&self.plant.sampled());
        if self.faults.is_off {
            samples.bus = BusState::Off;
        }
        self.next_us += PERIOD_US;
        let outputs = self.actuator.step(&samples, self.now_us());
        self.is_acceptance_old = true;
        self.plant.tick(bridge(outputs.bridge), &mut |_, _| {});
        // The virtual bus has no bit rate.
        let _ = self.actuator.device.drive.take_bit_rate();
        self.save();
        true
    }

    /// Begins or ends a fault.
    pub fn apply(&mut self, change: Change) {
        self.faults.apply(change, &mut self.plant.plant.defects);
    }

    /// The defects of the plant.
    pub fn defects(&mut self) -> &mut Defects {
        &mut self.plant.plant.defects
    }

    /// The time of the next control period, us.
    pub fn next_us(&self) -> u64 {
        self.next_us
    }

    /// Skips late control periods. The time of the node stands still meanwhile: the heartbeats that
    /// it has not received yet are not late.
    pub fn skip_to(&mut self, now_us: u64) {
        let skipped_us = now_us.saturating_sub(self.next_us);
        self.skipped_us += skipped_us;
        self.next_us += skipped_us;
    }

    /// The time of the node's last control period.
    fn now_us(&self) -> u64 {
        self.next_us - PERIOD_US - self.skipped_us
    }

    fn save(&mut self) {
        let drive = &mut self.actuator.device.drive;
        if let Some(set) = drive.take_save() {
            self.saver.start(set);
        }
        loop {
            match self.saver.poll(&mut self.flash) {
                Progress::Running => {}
                Progress::Idle => return,
                end => return drive.saved(end == Progress::Done),
            }
        }
    }

    /// The angle of the shaft, deg.
    pub fn angle_deg(&self) -> f64 {
        self.plant.plant.reading().output.angle_deg
    }
}
