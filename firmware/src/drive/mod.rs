//! The actuator as a CANopen drive: the [`Application`] behind the object dictionary, with the
//! drive profile CiA 402.
//!
//! ```text
//! frames ── canopen::Node ── Drive ─┬─ cia402::Axis      states, modes, ramps
//!                                   ├─ Application       loop, protections, parameters
//!                                   ├─ Capture, MotorModel, excitations
//!                                   └─ ParameterStore    what 1010h stores
//! ```
//!
//! [`Device`] combines node and drive: frames and samples go in, frames and the state of the bridge
//! come out. It depends neither on the transport of the frames nor on the flash.
//!
//! # How CiA 402 drives the application
//!
//! Once a control period the axis computes a demand from controlword, mode and targets. A demand
//! for power becomes [`Request::Enable`], no demand becomes [`Request::Disable`], and a position
//! becomes [`Request::Command`]. A demanded velocity is a rate setpoint: it goes to the rate loop
//! without the gain of the position loop. A fault of the application is a fault of the axis. A stop
//! that the application executes by itself (`FaultReaction`) is shown by the axis and not
//! influenced.
//!
//! While an excitation runs, or the servo pulse commands, the axis follows their command and
//! continues from it afterwards.
//!
//! [`Request::Enable`]: crate::application::Request::Enable
//! [`Request::Disable`]: crate::application::Request::Disable
//! [`Request::Command`]: crate::application::Request::Command

mod command_state;
mod commands;
mod control;
mod device;
mod emergency;
mod failsafe;
mod limits;
mod measured;
mod model;
mod motion;
mod objects;
mod service;
mod step_state;
mod store;
mod stored;
#[cfg(test)]
mod tests;
mod update;

use canopen::{
    Counted,
    cia402::{Axis, Parameters},
};

pub use command_state::CommandState;
pub use commands::Commands;
pub use control::Control;
pub use device::{Device, RPDOS, TPDOS};
pub use emergency::emergency_frame;
pub use measured::Diagnostics;
pub use step_state::StepState;
pub use stored::StoredParameters;
pub use update::{Image, Slots, StageError, UpdateOrder};

use crate::{
    application::{Application, BoardState, CommandSource, Outputs, Samples, Start},
    capture::Capture,
    faults::FaultSet,
    measure::Ripple,
    parameters::ObjectValues,
    timing::thousandths,
};
use failsafe::Failsafe;
use model::MotorModel;
use motion::Motion;
use service::{ServiceAccess, ServiceState};
use store::ParameterStore;
use update::Update;

/// The ripple of the current in the motor that these values describe.
fn ripple(values: &ObjectValues) -> Ripple {
    Ripple::of(values.model.resistance_ohm, values.model.inductance_h)
}

/// The application behind the object dictionary.
#[derive(Debug)]
pub struct Drive<'a> {
    control: Counted<Control>,
    capture: Capture<'a>,
    commands: Counted<Commands>,
    values: ObjectValues,
    motion: Motion,
    failsafe: Failsafe,
    model: MotorModel,
    store: ParameterStore,
    update: Update<'a>,
    service: ServiceAccess,
    /// Faults that the drive detects itself: missing commands, and a refused enable.
    own: FaultSet,
    /// Control periods since the last servo pulse.
    pulse_age: u16,
    /// A bit rate that LSS has set.
    bit_rate_kbit_s: Option<u16>,
    /// Node-ID of the node; 0 for none.
    node_id: u8,
    /// Conditions at the start of the board, for the first reset of the node.
    start: Start,
    /// Counters of the board's program, which may write here at any time.
    pub diagnostics: Diagnostics,
}

impl<'a> Drive<'a> {
    /// A drive with these stored parameters, which captures into this buffer.
    ///
    /// ```
    /// use firmware::{application::{Start, BoardState}, drive::{Drive, StoredParameters}};
    ///
    /// let mut buffer = [0; 800];
    /// let drive = Drive::new(StoredParameters::DEFAULT, Start::default(), &mut buffer);
    /// assert_eq!(drive.application().state(), BoardState::Initialising);
    /// ```
    pub fn new(stored: StoredParameters, start: Start, buffer: &'a mut [i32]) -> Self {
        let values = stored.values;
        let application = Application::with_ripple(stored.board, start, ripple(&values));
        Self {
            control: Counted::new(Control {
                axis: Axis::new(),
                axis_parameters: limits::axis_parameters(&values, application.parameters()),
                application,
            }),
            capture: Capture::new(buffer),
            commands: Counted::new(Commands::DEFAULT),
            motion: Motion::default(),
            failsafe: Failsafe::default(),
            model: MotorModel::default(),
            store: ParameterStore::new(stored),
            update: Update::NEW,
            service: ServiceAccess::NEW,
            values,
            own: FaultSet::EMPTY,
            pulse_age: u16::MAX,
            bit_rate_kbit_s: None,
            node_id: 0,
            start,
            diagnostics: Diagnostics::default(),
        }
    }

    /// The application.
    pub fn application(&self) -> &Application {
        &self.control.application
    }

    /// The parameters of the axis.
    pub fn axis_parameters(&self) -> &Parameters {
        &self.control.axis_parameters
    }

    /// What a master commands.
    pub fn commands(&self) -> &Counted<Commands> {
        &self.commands
    }

    /// Application and axis.
    pub fn control(&self) -> &Counted<Control> {
        &self.control
    }

    /// All latched faults, of the application and of the drive.
    pub fn latched(&self) -> FaultSet {
        self.application().faults().latched().or(self.own)
    }

    /// Statusword 6041h.
    pub fn statusword(&self) -> u16 {
        self.motion.statusword
    }

    /// The set to be written to the flash, once; [`Drive::saved`] reports the result.
    pub fn take_save(&mut self) -> Option<&StoredParameters> {
        self.store.take_request()
    }

    /// The save that [`Drive::take_save`] requested has succeeded or failed.
    pub fn saved(&mut self, is_successful: bool) {
        self.store.finish(is_successful);
    }

    /// The duty was written too late for its PWM edge: the last period counts as missed.
    pub fn was_late(&mut self) {
        self.control.application.was_late();
    }

    /// The bit rate to switch to, kbit/s, once.
    pub fn take_bit_rate(&mut self) -> Option<u16> {
        self.bit_rate_kbit_s.take()
    }

    /// One control period.
    pub fn step(&mut self, samples: &Samples) -> Outputs {
        self.pulse_age = match samples.servo_pulse_us {
            Some(_) => 0,
            None => self.pulse_age.saturating_add(1),
        };
        self.service.step();
        self.acknowledge();
        let output = self.step_axis();
        self.apply_demand(&output);
        let outputs = self.control.application.step(samples);
        self.capture.sample(&outputs);
        self.model.step(&self.values.model, &outputs);
        outputs
    }

    /// Restarts with the stored parameters.
    fn power_on(&mut self) {
        let stored = self.store.stored();
        self.values = stored.values;
        let start = self.start;
        self.start = start.permanent();
        self.control.application =
            Application::with_ripple(stored.board, start, ripple(&self.values));
        self.control.axis = Axis::new();
        *self.commands = Commands::DEFAULT;
        self.motion = Motion::default();
        self.failsafe = Failsafe::default();
        self.model = MotorModel::default();
        self.own = FaultSet::EMPTY;
        self.service.lock();
        self.capture.stop();
        self.update_limits();
    }

    /// Updates the parameters of the axis after a change of stored values.
    fn update_limits(&mut self) {
        self.control.axis_parameters =
            limits::axis_parameters(&self.values, self.application().parameters());
    }

    fn is_driving(&self) -> bool {
        self.application().state().is_driving() || self.motion.is_powered
    }

    /// Whether the service password locks what it protects.
    fn is_locked(&self) -> bool {
        self.service.state(self.values.service.password) == ServiceState::Locked
    }

    fn angle_mdeg(&self) -> i32 {
        thousandths(self.application().telemetry().angle)
    }

    fn rate_mdeg_s(&self) -> i32 {
        thousandths(self.application().telemetry().rate)
    }

    /// Whether the commands come from the bus at present.
    fn is_commanded(&self) -> bool {
        // The axis takes over one period after the other source has ended: it starts from the
        // command of that source.
        self.application().source() == CommandSource::Bus
            && self.application().telemetry().source == CommandSource::Bus
    }

    fn has_failed(&self) -> bool {
        self.application().state() == BoardState::Fault
    }
}
