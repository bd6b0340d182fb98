//! The control loop of an actuator: everything that decides what the shaft does.
//!
//! ```text
//!                  samples, commands, parameters
//!                               │
//!   Loop::step ── axis           profiles, modes, limits of position and velocity
//!              ── failsafe       reaction to the loss of the master
//!              ── application    operating states, protections, cascade, stops
//!                               │
//!                    state of the bridge, telemetry
//! ```
//!
//! [`Loop::step`] is a pure function of its state and its inputs: it knows no bus, no object
//! dictionary, no store and no clock. Front ends (CANopen, servo pulse) post [`Commands`],
//! [`LoopParameters`] and [`ExcitationRequest`]s; the loop applies what is new between two control
//! periods and reports in [`Outputs`] what it has taken.

pub(crate) mod axis_parameters;
mod commands;
mod failsafe;
mod feed_forward;
mod motion;
mod parameters;
mod targets;

use canopen::cia402::{Axis, Cia402State, Mode};

pub(crate) use self::commands::ends_motion;
pub(crate) use self::feed_forward::ForwardGains;
pub use self::{
    commands::{Command, Commands, ExcitationRequest, Numbered},
    parameters::LoopParameters,
    targets::Targets,
};
use self::{failsafe::Failsafe, feed_forward::Demanded};
use crate::{
    application::{Application, BoardState, CommandSource, Outputs, Request, Samples, Start},
    faults::FaultSet,
    interface::{Motion, Taken},
};

pub(crate) use axis_parameters::Polarity;

/// Length of a control period, us.
pub(crate) const PERIOD_US: u32 = axis_parameters::PERIOD_US;

/// Inputs of a control period.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// The samples.
    pub samples: &'a Samples,
    /// The last step ended too late: its duty took effect one update period after it was due. That
    /// counts as a missed control period, but no sample was lost.
    pub was_late: bool,
    /// The commands.
    pub commands: &'a Commands,
    /// The parameters.
    pub parameters: &'a LoopParameters,
    /// The excitation that was requested last.
    pub excitation: &'a ExcitationRequest,
}

/// The control loop: the parameters in force, and the state.
#[derive(Debug, Clone)]
pub struct Loop {
    parameters: LoopParameters,
    state: State,
}

/// What a control period changes.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    application: Application,
    axis: Axis<PERIOD_US>,
    /// The command of this control period.
    command: Command,
    failsafe: Failsafe,
    demanded: Demanded,
    /// Faults of commands, which the application does not detect: missing ones, and a refused
    /// enable.
    command_faults: FaultSet,
    /// Control periods since the last servo pulse.
    pulse_age: u16,
    /// The circumstances that remain for a restart.
    start: Start,
}

/// Targets that were written since the last control period.
#[derive(Debug, Clone, Copy)]
struct Written {
    position: bool,
    velocity: bool,
    torque: bool,
}

impl Written {
    /// Whether it is the target of this cyclic mode.
    const fn of_cyclic_mode(&self, mode: Mode) -> bool {
        match mode {
            Mode::CyclicVelocity => self.velocity,
            Mode::CyclicTorque => self.torque,
            _ => self.position,
        }
    }
}

impl Loop {
    /// A loop after a reset of any kind, which has taken the content of its mailboxes.
    ///
    /// ```
    /// use firmware::application::{BoardState, Start};
    /// use firmware::control_loop::{Commands, ExcitationRequest, Loop, LoopParameters};
    /// use firmware::drive::StoredParameters;
    ///
    /// let parameters = LoopParameters::of(&StoredParameters::DEFAULT);
    /// let mailboxes = (&Commands::new(), &parameters, &ExcitationRequest::NONE);
    /// let control_loop = Loop::new(mailboxes, Start::default());
    /// assert_eq!(control_loop.application().state(), BoardState::Initialising);
    /// ```
    pub fn new(
        (commands, parameters, excitation): (&Commands, &LoopParameters, &ExcitationRequest),
        start: Start,
    ) -> Self {
        Self {
            parameters: *parameters,
            state: State::new((commands, parameters, excitation), start),
        }
    }

    /// The parameters in force.
    pub fn parameters(&self) -> &LoopParameters {
        &self.parameters
    }

    /// The state.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Operating states, protections and cascade.
    pub fn application(&self) -> &Application {
        &self.state.application
    }

    /// What the loop has taken from its mailboxes.
    pub fn taken(&self) -> &Taken {
        self.state.taken()
    }

    /// The outputs of the last control period.
    pub fn outputs(&self) -> &Outputs {
        self.state.application.outputs()
    }

    /// One control period.
    pub fn step(&mut self, inputs: &Inputs<'_>) -> &Outputs {
        self.take_messages(inputs);
        self.state.control_period(&self.parameters, inputs);
        self.outputs()
    }

    /// Restarts once the shaft has been stopped, or takes a new set of parameters in the first
    /// control period whose state permits its changes.
    fn take_messages(&mut self, inputs: &Inputs<'_>) {
        let Inputs {
            commands,
            parameters,
            excitation,
            ..
        } = *inputs;
        if self.state.is_restarting(commands) {
            if self
                .state
                .application
                .has_stopped(&self.parameters.board.stop)
            {
                self.parameters = *parameters;
                let known = self.state.application.known_motor();
                self.state = State::new((commands, parameters, excitation), self.state.start);
                self.state.application.continue_with(known);
            }
            return;
        }
        if parameters.number != self.state.taken().parameters && self.apply(parameters) {
            self.state.taken_mut().parameters = parameters.number;
        }
        if excitation.number != self.state.taken().excitation {
            self.state.take_excitation(excitation);
        }
    }

    /// Applies a set of parameters; returns false, without effect, if the state does not permit it.
    fn apply(&mut self, parameters: &LoopParameters) -> bool {
        let present = &self.parameters.board;
        let application = &mut self.state.application;
        if !(self.parameters.forward).may_change(application.state(), &parameters.forward) {
            return false;
        }
        let corrects_another = parameters.encoder.differs_from(&self.parameters.encoder);
        if corrects_another && application.state().is_driving() {
            return false;
        }
        if parameters.board != *present && application.retune(present, &parameters.board).is_err() {
            return false;
        }
        if !(parameters.motor).has_back_emf_of(&self.parameters.motor) {
            application.forget_constant();
        }
        if corrects_another {
            application.correct_encoder(&parameters.encoder);
        }
        self.parameters = *parameters;
        true
    }
}

impl State {
    fn new(
        (commands, parameters, excitation): (&Commands, &LoopParameters, &ExcitationRequest),
        start: Start,
    ) -> Self {
        let taken = Taken {
            command: commands.first(),
            parameters: parameters.number,
            excitation: excitation.number,
            source: commands.source.number,
            network_loss: commands.network_loss.number,
            restarts: commands.restarts,
            sample_due: None,
        };
        Self {
            application: Application::reporting(taken, &parameters.board, start),
            axis: Axis::starting_from(parameters.origin_mdeg),
            command: *commands.at(commands.first()),
            failsafe: Failsafe::default(),
            demanded: Demanded::default(),
            command_faults: FaultSet::EMPTY,
            pulse_age: u16::MAX,
            start: start.permanent(),
        }
    }

    /// What the loop has taken from its mailboxes, as it reports it.
    fn taken(&self) -> &Taken {
        &self.application.outputs().taken
    }

    fn taken_mut(&mut self) -> &mut Taken {
        &mut self.application.outputs_mut().taken
    }

    /// The state of the axis, as the loop reports it.
    fn motion(&mut self) -> &mut Motion {
        &mut self.application.outputs_mut().motion
    }

    /// Whether a restart is requested: until the shaft is at rest, nothing else is taken.
    fn is_restarting(&self, commands: &Commands) -> bool {
        commands.restarts != self.taken().restarts
    }

    fn control_period(&mut self, parameters: &LoopParameters, inputs: &Inputs<'_>) {
        self.pulse_age = match inputs.samples.servo_pulse_us {
            Some(_) => 0,
            None => self.pulse_age.saturating_add(1),
        };
        if inputs.was_late {
            self.application.was_late();
        }
        if self.is_restarting(inputs.commands) {
            // Refused where the shaft decelerates already.
            let _ = self.application.request(Request::QuickStop);
            *self.motion() = Motion::default();
        } else {
            self.take_requests(inputs.commands);
            let written = self.take_command(inputs.commands);
            self.acknowledge();
            let demand = self.step_axis(parameters, written);
            self.apply_demand(parameters, &demand);
        }
        let settings = parameters.settings();
        self.application.control_period(settings, inputs.samples);
        let sample_due = self.application.sample_due();
        self.taken_mut().sample_due = sample_due;
        self.report();
    }

    fn take_excitation(&mut self, excitation: &ExcitationRequest) {
        self.taken_mut().excitation = excitation.number;
        match excitation.run {
            // Refused while the loop is not closed.
            Some(run) => _ = self.application.start_excitation(run),
            None => _ = self.application.request(Request::StopExcitation),
        }
    }

    fn take_requests(&mut self, commands: &Commands) {
        if commands.source.number != self.taken().source {
            self.taken_mut().source = commands.source.number;
            // Refused for an excitation, which is started instead.
            let _ = (self.application).request(Request::Source(commands.source.value));
        }
        if commands.network_loss.number != self.taken().network_loss {
            self.taken_mut().network_loss = commands.network_loss.number;
            self.failsafe.network(commands.network_loss.value);
        }
        let (excitation, sample) = commands.sample;
        if excitation == self.taken().excitation {
            self.application.take_sample(sample);
        }
    }

    /// Takes the next command of the queue, which waits for the end of the initialisation; returns
    /// which targets were written for it.
    fn take_command(&mut self, commands: &Commands) -> Written {
        let is_ready = self.axis.state() != Cia402State::NotReadyToSwitchOn;
        if is_ready && self.taken().command != commands.number() {
            let next = self.taken().command.wrapping_add(1);
            self.taken_mut().command = next;
        }
        let command = commands.at(self.taken().command);
        let before = &self.command;
        let written = Written {
            position: command.position_writes != before.position_writes,
            velocity: command.velocity_writes != before.velocity_writes,
            torque: command.torque_writes != before.torque_writes,
        };
        self.command = *command;
        if written.of_cyclic_mode(command.mode) {
            self.failsafe.commanded();
        }
        written
    }

    fn report(&mut self) {
        let latched = self.latched();
        let outputs = self.application.outputs_mut();
        outputs.fault = outputs.fault.or(self.command_faults.first());
        outputs.telemetry.latched = latched;
        outputs.telemetry.pulse_age = self.pulse_age;
    }

    /// All latched faults, of the application and of the commands.
    fn latched(&self) -> FaultSet {
        self.application.latched().all().or(self.command_faults)
    }

    /// Whether the commands of the mailbox are followed at present.
    fn is_commanded(&self) -> bool {
        // The axis takes over one period after the other source has ended: it starts from the
        // command of that source.
        self.application.source() == CommandSource::Bus
            && self.application.telemetry().source == CommandSource::Bus
    }

    fn has_failed(&self) -> bool {
        matches!(
            self.application.state(),
            BoardState::Fault | BoardState::FaultHold
        )
    }
}
