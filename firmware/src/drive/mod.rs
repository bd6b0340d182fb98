//! The actuator as a CANopen drive: the object dictionary and the drive profile CiA 402 in front of
//! the [control loop](crate::control_loop).
//!
//! ```text
//! frames ── canopen::Node ── Drive ─┬─ mailboxes         commands and parameters for the loop
//!                                   ├─ telemetry         the last outputs of the loop
//!                                   ├─ Capture, MotorModel
//!                                   └─ ParameterStore    what 1010h stores
//! ```
//!
//! [`Device`] combines node and drive: frames and outputs of the loop go in, frames and messages to
//! the loop come out. It depends neither on the transport of the frames nor on the flash.
//!
//! A write of an object changes a message: an edge is queued in [`Commands`], a parameter is
//! checked with all others and becomes part of [`LoopParameters`]. Whether a write is permitted
//! follows from the state that the loop reported last; the loop checks it once more.

mod commands;
mod device;
mod dronecan;
mod emergency;
mod front_end;
mod measured;
mod model;
mod objects;
mod points;
mod service;
mod servo_bus;
mod store;
mod stored;
#[cfg(test)]
mod tests;
mod touch_probe;
mod update;

pub use device::{Device, RPDOS, TPDOS};
pub use measured::Diagnostics;
pub use points::Points;
pub use servo_bus::{Elapsed, Maker as ServoMaker, Model as ServoModel, ServoBus};
pub use stored::StoredParameters;
pub use update::{Image, Slots, StageError, UpdateOrder};

use canopen::cia402::Cia402State;

use crate::{
    application::{CommandSource, Outputs, Start},
    capture::Capture,
    check_value::Checked,
    control_loop::{Commands, ExcitationRequest, Loop, LoopParameters},
    faults::{Fault, FaultSet},
    health::Health,
    parameters::{BoardParameters, ObjectValues},
    protection::Counter,
    timing::thousandths,
};
use model::MotorModel;
use service::{ServiceAccess, ServiceState};
use store::ParameterStore;
use touch_probe::TouchProbes;
use update::Update;

/// With these faults the telemetry has no angle.
const ANGLE_UNKNOWN: FaultSet =
    FaultSet::of(&[Fault::EncoderInvalid, Fault::MagnetLost, Fault::EncoderJump]);

/// The messages to the control loop.
#[derive(Debug, Clone)]
pub struct Messages {
    /// The commands.
    pub commands: Checked<Commands>,
    /// The parameters.
    pub parameters: Checked<LoopParameters>,
    /// The excitation that was requested last.
    pub excitation: Checked<ExcitationRequest>,
}

impl Messages {
    /// No command, and these parameters. Not inlined: its temporaries stay out of the stack frame
    /// of the initialisation, which is the largest one.
    #[inline(never)]
    fn of(stored: &StoredParameters) -> Self {
        Self {
            commands: Checked::new(Commands::new()),
            parameters: Checked::new(LoopParameters::of(stored)),
            excitation: Checked::new(ExcitationRequest::NONE),
        }
    }

    /// A control loop that has taken these messages, after a reset of any kind.
    pub fn start(&self, start: Start) -> Loop {
        let parameters = self.parameters.unverified();
        let (commands, excitation) = (self.commands.unverified(), self.excitation.unverified());
        Loop::new((commands, parameters, excitation), start)
    }
}

/// The control loop behind the object dictionary.
#[derive(Debug)]
pub struct Drive<'a> {
    /// What is posted to the control loop.
    pub messages: Messages,
    /// What the loop has reported last.
    outputs: Outputs,
    /// The counters of the protections, each as it was reported last.
    counters: [u16; Counter::ALL.len()],
    /// Faults of which the node has sent an EMCY since its reset.
    reported: FaultSet,
    capture: Capture<'a>,
    values: ObjectValues,
    /// The points of the interpolated position mode that wait.
    pub points: Points,
    touch_probes: TouchProbes,
    /// Object 2055h, by which a master and the program that commissions agree.
    commissioning: u8,
    model: MotorModel,
    health: Health,
    store: ParameterStore,
    update: Update<'a>,
    service: ServiceAccess,
    /// The present frame has queued a command, which further objects of the frame join.
    has_queued: bool,
    /// A bit rate that LSS has set.
    bit_rate_kbit_s: Option<u16>,
    /// The servo bus commands, and CANopen does not.
    is_on_servo_bus: bool,
    /// CANopen has ended the motion since the servo bus turned the torque on.
    is_stopped: bool,
    /// The limit of the torque on the servo bus, beside object 6072h.
    servo_torque_permille: u16,
    /// Node-ID of the node; 0 for none.
    node_id: u8,
    /// Counters of the board's program, which may write here at any time.
    pub diagnostics: Diagnostics,
}

impl<'a> Drive<'a> {
    /// A drive with these stored parameters, which captures into this buffer.
    ///
    /// ```
    /// use firmware::{application::BoardState, drive::{Drive, StoredParameters}};
    ///
    /// let mut buffer = [0; 800];
    /// let drive = Drive::new(StoredParameters::DEFAULT, &mut buffer);
    /// assert_eq!(drive.outputs().state, BoardState::Initialising);
    /// ```
    pub fn new(stored: StoredParameters, buffer: &'a mut [i32]) -> Self {
        Self {
            messages: Messages::of(&stored),
            outputs: outputs_at_start(&stored.board),
            counters: [0; Counter::ALL.len()],
            reported: FaultSet::EMPTY,
            capture: Capture::new(buffer),
            points: Points::default(),
            touch_probes: TouchProbes::default(),
            commissioning: 0,
            model: MotorModel::default(),
            health: Health::default(),
            store: ParameterStore::new(stored),
            update: Update::NEW,
            service: ServiceAccess::NEW,
            values: *stored.values(),
            has_queued: false,
            bit_rate_kbit_s: None,
            is_on_servo_bus: false,
            is_stopped: false,
            servo_torque_permille: u16::MAX,
            node_id: 0,
            diagnostics: Diagnostics::default(),
        }
    }

    /// The last outputs of the control loop.
    pub fn outputs(&self) -> &Outputs {
        &self.outputs
    }

    /// The parameters of the board that were set last.
    pub fn parameters(&self) -> &BoardParameters {
        &self.messages.parameters.unverified().board
    }

    /// All latched faults.
    pub fn latched(&self) -> FaultSet {
        self.outputs.telemetry.latched
    }

    /// The set to be written to the flash, once; [`Drive::saved`] reports the result.
    pub fn take_save(&mut self) -> Option<&StoredParameters> {
        self.store.take_request()
    }

    /// The save that [`Drive::take_save`] requested has succeeded or failed.
    pub fn saved(&mut self, is_successful: bool) {
        self.store.finish(is_successful);
    }

    /// The bit rate to switch to, kbit/s, once.
    pub fn take_bit_rate(&mut self) -> Option<u16> {
        self.bit_rate_kbit_s.take()
    }

    /// Takes the outputs of a control period.
    pub fn observe(&mut self, outputs: &Outputs) {
        let passed = outputs
            .telemetry
            .tick
            .wrapping_sub(self.outputs.telemetry.tick);
        let was_enabled = self.is_enabled();
        copy(&mut self.outputs, outputs);
        if was_enabled && !self.is_enabled() {
            // What was left of a motion moves nothing in the next one.
            self.points.clear();
        }
        if let Some(counter) = self
            .counters
            .get_mut(Counter::of_tick(outputs.telemetry.tick) as usize)
        {
            *counter = outputs.telemetry.counter;
        }
        self.post_point(passed);
        if self.touch_probes.function() != 0 {
            let is_known = outputs.telemetry.present.and(ANGLE_UNKNOWN).is_empty();
            let angle = is_known.then(|| thousandths(outputs.telemetry.angle));
            (self.touch_probes).turned(angle, outputs.motion.origin_mdeg);
        }
        self.values.homing.origin_mdeg = outputs.motion.origin_mdeg;
        self.service.control_period();
        self.capture.sample(outputs);
        self.model.step(&self.values.model, outputs);
        let values = &self.values;
        self.health.observe(&values.health, &values.model, outputs);
    }

    /// Restarts with the stored parameters.
    fn power_on(&mut self) {
        let stored = self.store.stored();
        self.values = *stored.values();
        self.outputs = outputs_at_start(&stored.board);
        self.counters = [0; Counter::ALL.len()];
        self.reported = FaultSet::EMPTY;
        self.messages.parameters.update(|parameters| {
            *parameters = LoopParameters {
                number: parameters.number.wrapping_add(1),
                ..LoopParameters::of(stored)
            };
        });
        self.messages.commands.update(Commands::restart);
        self.outputs.taken.command = self.messages.commands.unverified().number();
        self.messages.excitation.update(ExcitationRequest::stop);
        self.points = Points::default();
        self.touch_probes = TouchProbes::default();
        self.commissioning = 0;
        self.model = MotorModel::default();
        self.health = Health::default();
        self.service.lock();
        self.servo_torque_permille = u16::MAX;
        self.capture.stop();
    }

    /// In OPERATION ENABLED.
    fn is_enabled(&self) -> bool {
        self.outputs.motion.state == Cia402State::OperationEnabled
    }

    fn is_driving(&self) -> bool {
        self.outputs.state.is_driving() || self.outputs.motion.is_powered
    }

    /// Whether the service password locks what it protects.
    fn is_locked(&self) -> bool {
        self.service.state(self.values.service.password) == ServiceState::Locked
    }

    /// Whether an excitation runs or is about to start.
    fn is_exciting(&self) -> bool {
        let request = self.messages.excitation.unverified();
        if request.number == self.outputs.taken.excitation {
            self.outputs.telemetry.source == CommandSource::Excitation
        } else {
            request.run.is_some()
        }
    }

    /// The source of commands that is selected or about to be.
    fn selected_source(&self) -> CommandSource {
        let request = self.messages.commands.unverified().source;
        if request.number == self.outputs.taken.source {
            self.outputs.telemetry.selected_source
        } else {
            request.value
        }
    }

    /// Computes the sample of the running excitation that the next control period needs.
    fn prepare_sample(&mut self) {
        let request = self.messages.excitation.unverified();
        let (Some(run), Some(tick)) = (&request.run, self.outputs.taken.sample_due) else {
            return;
        };
        if request.number == self.outputs.taken.excitation {
            let sample = (request.number, run.sample(tick));
            (self.messages.commands).update(|commands| commands.sample = sample);
        }
    }
}

/// What is reported before the first control period.
fn outputs_at_start(parameters: &BoardParameters) -> Outputs {
    let mut outputs = Outputs::default();
    outputs.telemetry.selected_source = CommandSource::of(&parameters.command);
    outputs
}

/// Copies outputs. Inlined, it would be split around each field that is read behind it, into
/// unaligned parts.
#[inline(never)]
fn copy(to: &mut Outputs, from: &Outputs) {
    *to = *from;
}
