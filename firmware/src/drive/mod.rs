//! The actuator as a CANopen drive: the [`Application`] behind the object dictionary, with the drive profile CiA 402 in
//! front of it.
//!
//! ```text
//! frames ── canopen::Node ── Drive ─┬─ cia402::Axis    states, modes, ramps
//!                                   ├─ Application     loop, protections, parameters
//!                                   ├─ Capture, Model, excitations
//!                                   └─ Set             what 1010h stores
//! ```
//!
//! [`Device`] is the node and the drive together: frames and samples go in, frames and the bridge's state come out. Nothing
//! of it knows how frames travel or where the flash is.
//!
//! # How CiA 402 drives the application
//!
//! Once a control period the axis makes a demand of controlword, mode and targets. A demand for power
//! is [`Request::Enable`], none is [`Request::Disable`], and a position goes on as [`Request::Command`]. A demanded velocity
//! `v` goes through the position loop, of gain `P`, as the angle `angle + v T + v/P`: the commanded rate is then `v`, and every
//! protection of the position loop watches it. A fault of the application is a fault of the axis; what the
//! application stops by itself (`FaultReaction`) the axis shows and does not touch.
//!
//! While an excitation runs, or the servo pulse commands, the axis follows their command and takes over where it is.
//!
//! [`Request::Enable`]: crate::application::Request::Enable
//! [`Request::Disable`]: crate::application::Request::Disable
//! [`Request::Command`]: crate::application::Request::Command

mod device;
mod diagnostics;
mod emergency;
mod failsafe;
mod kept;
mod model;
mod motion;
mod numbers;
mod objects;
mod parameters;
mod read;
mod set;
#[cfg(test)]
mod tests;
mod write;

use canopen::cia402::Axis;

pub use device::{Device, RPDOS, TPDOS};
pub use diagnostics::Diagnostics;
pub use set::Set;

use crate::{
    application::{Application, BoardState, CommandSource, Outputs, Samples, Start},
    capture::Capture,
    faults::FaultSet,
    parameters::BoardParameters,
    timing::thousandths,
};
use failsafe::Failsafe;
use kept::Kept;
use model::Model;
use motion::Motion;
use set::Store;

/// What a master commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Commands {
    controlword: u16,
    mode: i8,
    target_position_mdeg: i32,
    target_velocity_mdeg_s: i32,
    velocity_offset_mdeg_s: i32,
}

impl Commands {
    /// Cyclic synchronous position, and nothing to be done.
    const DEFAULT: Self = Self {
        controlword: 0,
        mode: 8,
        target_position_mdeg: 0,
        target_velocity_mdeg_s: 0,
        velocity_offset_mdeg_s: 0,
    };
}

/// The application behind the object dictionary.
#[derive(Debug)]
pub struct Drive<'a> {
    application: Application,
    capture: Capture<'a>,
    axis: Axis,
    axis_parameters: canopen::cia402::Parameters,
    commands: Commands,
    kept: Kept,
    motion: Motion,
    failsafe: Failsafe,
    model: Model,
    store: Store,
    source: CommandSource,
    /// Faults of the way to the application: commands that stay out, and power that was refused.
    own: FaultSet,
    /// Control periods since a servo pulse.
    pulse_age: u16,
    bit_rate_kbit_s: Option<u16>,
    /// Of the node; 0 for none.
    node_id: u8,
    /// What the board started after, until the first reset of the node, which is that start.
    start: Start,
    /// What only the board knows; it may write here at any time.
    pub diagnostics: Diagnostics,
}

impl<'a> Drive<'a> {
    /// A drive with what was stored, which captures into this buffer.
    ///
    /// ```
    /// use firmware::{application::{Start, BoardState}, drive::{Drive, Set}};
    ///
    /// let mut buffer = [0; 800];
    /// let drive = Drive::new(Set::defaults(), Start::default(), &mut buffer);
    /// assert_eq!(drive.application().state(), BoardState::Initialising);
    /// ```
    pub fn new(stored: Set, start: Start, buffer: &'a mut [i32]) -> Self {
        let application = Application::after(stored.board, start);
        let kept = stored.kept();
        Self {
            axis: Axis::new(),
            axis_parameters: parameters::axis(&kept, application.parameters()),
            source: source_of(application.parameters()),
            application,
            capture: Capture::new(buffer),
            commands: Commands::DEFAULT,
            motion: Motion::default(),
            failsafe: Failsafe::default(),
            model: Model::default(),
            store: Store::new(stored),
            kept,
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
        &self.application
    }

    /// Everything that is latched: of the application, and of the way to it.
    pub fn latched(&self) -> FaultSet {
        self.application.faults().latched().or(self.own)
    }

    /// Statusword 6041h.
    pub fn statusword(&self) -> u16 {
        self.motion.statusword
    }

    /// What is to be written to the flash, once; tell by [`Drive::saved`] what came of it.
    pub fn take_save(&mut self) -> Option<&Set> {
        self.store.take()
    }

    /// The save that [`Drive::take_save`] asked for is over.
    pub fn saved(&mut self, done: bool) {
        self.store.finish(done);
    }

    /// The bridge was told too late for the edge that was meant: the last period counts as missed.
    pub fn was_late(&mut self) {
        self.application.was_late();
    }

    /// The bit rate to go over to, kbit/s, once.
    pub fn take_bit_rate(&mut self) -> Option<u16> {
        self.bit_rate_kbit_s.take()
    }

    /// One control period.
    pub fn step(&mut self, samples: &Samples) -> Outputs {
        self.pulse_age = match samples.servo_pulse_us {
            Some(_) => 0,
            None => self.pulse_age.saturating_add(1),
        };
        self.acknowledge();
        let output = self.step_axis();
        self.apply_demand(&output);
        let outputs = self.application.step(samples);
        self.capture.sample(&outputs);
        self.model.step(&self.kept, &outputs);
        outputs
    }

    /// Starts over with what is stored.
    fn power_on(&mut self) {
        let set = self.store.set();
        self.application = Application::after(set.board, core::mem::take(&mut self.start));
        self.kept = set.kept();
        self.axis = Axis::new();
        self.commands = Commands::DEFAULT;
        self.motion = Motion::default();
        self.failsafe = Failsafe::default();
        self.model = Model::default();
        self.own = FaultSet::EMPTY;
        self.source = source_of(self.application.parameters());
        self.capture.stop();
        self.update_limits();
    }

    /// A parameter has changed: the axis has others.
    fn update_limits(&mut self) {
        self.axis_parameters = parameters::axis(&self.kept, self.application.parameters());
    }

    fn is_driving(&self) -> bool {
        self.application.state().is_driving() || self.motion.is_powered
    }

    fn angle_mdeg(&self) -> i32 {
        thousandths(self.application.telemetry().angle)
    }

    fn rate_mdeg_s(&self) -> i32 {
        thousandths(self.application.telemetry().rate)
    }

    /// Whether the commands come from the bus at present.
    fn is_commanded(&self) -> bool {
        self.application.telemetry().source == CommandSource::Bus
            && self.source == CommandSource::Bus
    }

    fn has_failed(&self) -> bool {
        self.application.state() == BoardState::Fault
    }
}

fn source_of(parameters: &BoardParameters) -> CommandSource {
    if parameters.command.command_source == 1 {
        CommandSource::ServoPulse
    } else {
        CommandSource::Bus
    }
}
