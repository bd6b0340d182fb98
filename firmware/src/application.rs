//! One control period of the board, and its operating states.
//!
//! | from | to | when |
//! |---|---|---|
//! | initialising | disabled | encoder, current, supply and temperature were measured, and the shaft does not turn, or a second has passed |
//! | initialising | fault | they were not within 200 ms; or the watchdog caused the reset; or the stored parameters are corrupt |
//! | disabled | enabled | [`Request::Enable`], and no fault is present |
//! | enabled | disabled | [`Request::Disable`] |
//! | enabled | quick stop | [`Request::QuickStop`] |
//! | quick stop | disabled | the shaft is at rest and is not to be held; [`Request::Disable`] |
//! | quick stop | enabled | [`Request::Enable`] |
//! | enabled, quick stop | fault reaction | a fault whose reaction is a quick stop |
//! | enabled, quick stop, fault reaction | fault reaction | a fault whose reaction is a stop by the back-EMF, and after which the motor may brake |
//! | fault reaction | fault hold | the shaft is at rest, and all latched faults permit to hold it |
//! | fault reaction | fault | the shaft is at rest; `quick_stop_ms` has elapsed; [`Request::Disable`] |
//! | fault hold | fault reaction | a fault whose reaction is a stop |
//! | fault hold | fault | the shaft is not held within the window of the following error; [`Request::Disable`] |
//! | any | fault | any other fault |
//! | fault, fault hold | disabled | [`Request::Acknowledge`] |
//!
//! While the bridge is off, faults are reported in [`Telemetry::present`] and block
//! [`Request::Enable`], but are not latched. Only events that would be lost otherwise are latched
//! in every state: a trip of the bridge, missed control periods, corrupt parameters and a reset by
//! the watchdog.
//!
//! Order of a control period: measure, validate the encoder's word, observe, select the setpoint,
//! protect, change the state, regulate, make the compare value of the duty.

mod back_emf_brake;
mod current_limit;
mod dead_band;
mod feed_forward;
mod known_motor;
mod regulation;
mod requests;
mod stop_progress;
mod stopping;
mod torque;

use model_core::control::{
    cascade::{CascadeState, CascadeStep, Setpoint},
    pwm_timer::{Modulator, PwmCompare},
};

pub use crate::interface::{
    BoardState, Bridge, BusState, CommandSource, Motion, Outputs, Refused, Request, Samples, Scan,
    Settings, Taken, Telemetry, TorqueSetpoint,
};

pub(crate) use self::requests::may_retune;
pub use self::{current_limit::MotorLimits, dead_band::DeadBandSettings};

use self::{
    back_emf_brake::BackEmfBrake, current_limit::CurrentLimit, dead_band::DeadBand,
    feed_forward::FeedForward, stop_progress::StopProgress, stopping::Stopping,
};
use crate::{
    command::SetpointSource,
    faults::{ALWAYS, Fault, FaultSet, LatchedFaults, OF_COMMANDS, PERMANENT, Reaction},
    measure::Single,
    parameters::{BoardParameters, StopSettings},
    protection::{Conditions, Counter, Measured, Protection, Winding},
    timing::{periods, rate_of_mdeg_s},
    velocity::VelocityTracker,
};

/// Control periods within which all quantities must be measured after a reset: the AS5045 takes up
/// to 80 ms to its first angle (data sheet, power-up time).
const INITIALISING_PERIODS: u32 = periods(200) as u32;

/// Control periods after which the encoder's rate is that of the shaft, and after which the board
/// no longer waits for one that is lost.
const ENCODER_SETTLED_PERIODS: u32 = periods(40) as u32;
const ENCODER_LOST_PERIODS: u32 = periods(1000) as u32;

/// After these faults the position is unknown: the next valid count may be a turn away.
const POSITION_LOST: FaultSet =
    FaultSet::of(&[Fault::EncoderInvalid, Fault::MagnetLost, Fault::EncoderJump]);

/// After these faults the position is not what the encoder shows.
const POSITION_WRONG: FaultSet = FaultSet::of(&[Fault::EncoderStuck, Fault::EncoderImplausible]);

/// After one of these faults the rate by the encoder does not stand for a back-EMF.
const ENCODER_WRONG: FaultSet = POSITION_LOST
    .or(POSITION_WRONG)
    .or(FaultSet::of(&[Fault::MotorPolarity]));

/// A reset by the pin, the supply or a request brakes where one by the watchdog does.
const AFTER_A_RESET: FaultSet = FaultSet::of(&[Fault::WatchdogReset]);

/// Circumstances of the reset that are relevant to the application.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Start {
    /// The watchdog caused it.
    pub watchdog: bool,
    /// There are stored parameters, but they cannot be read.
    pub parameters_corrupt: bool,
    /// A shutdown has restarted the program, and its flash is as built.
    pub data_corrupt: bool,
    /// The program's flash is not that of the program that was built.
    pub program_corrupt: bool,
}

impl Start {
    fn faults(self) -> FaultSet {
        let mut faults = FaultSet::EMPTY;
        faults.put(Fault::WatchdogReset, self.watchdog);
        faults.put(Fault::ParametersCorrupt, self.parameters_corrupt);
        faults.put(Fault::DataCorrupt, self.data_corrupt);
        faults.put(Fault::ProgramCorrupt, self.program_corrupt);
        faults
    }

    /// What remains at the second start of the node.
    pub(crate) fn permanent(self) -> Self {
        Self {
            program_corrupt: self.program_corrupt,
            ..Self::default()
        }
    }
}

/// The state of the application.
#[derive(Debug, Clone, PartialEq)]
pub struct Application {
    control: CascadeState,
    velocity: VelocityTracker,
    state: BoardState,
    /// The last control step; its duty stays in force while there is no valid count.
    last_step: CascadeStep,
    modulator: Modulator,
    compare: PwmCompare,
    setpoints: SetpointSource,
    protection: Protection,
    stopping: Stopping,
    /// The stop without an encoder, in [`BoardState::FaultReaction`].
    back_emf_stop: Option<StopProgress>,
    back_emf_brake: BackEmfBrake,
    current_limit: CurrentLimit,
    feed_forward: FeedForward,
    dead_band: DeadBand,
    latched: LatchedFaults,
    start: FaultSet,
    is_late: bool,
    /// The last outputs.
    outputs: Outputs,
}

impl Application {
    /// An application after a reset of any kind; its causes become faults.
    ///
    /// ```
    /// use firmware::application::{Application, BoardState, Start};
    /// use firmware::parameters::BoardParameters;
    ///
    /// let start = Start { watchdog: true, ..Start::default() };
    /// let application = Application::new(&BoardParameters::DEFAULT, start);
    /// assert_eq!(application.state(), BoardState::Initialising);
    /// assert!(application.latched().all().is_empty());
    /// ```
    pub fn new(parameters: &BoardParameters, start: Start) -> Self {
        Self::reporting(Taken::default(), parameters, start)
    }

    /// The same, which reports what its loop has taken.
    pub(crate) fn reporting(taken: Taken, parameters: &BoardParameters, start: Start) -> Self {
        Self {
            control: CascadeState::default(),
            velocity: VelocityTracker::default(),
            state: BoardState::Initialising,
            last_step: CascadeStep::default(),
            modulator: Modulator::default(),
            compare: PwmCompare::default(),
            setpoints: SetpointSource::new(&parameters.command),
            protection: Protection::new(),
            stopping: Stopping::default(),
            back_emf_stop: None,
            back_emf_brake: BackEmfBrake::default(),
            current_limit: CurrentLimit::default(),
            feed_forward: FeedForward::default(),
            dead_band: DeadBand::default(),
            latched: LatchedFaults::default(),
            start: start.faults(),
            is_late: false,
            outputs: no_outputs(taken),
        }
    }

    /// The temperatures of the motor.
    pub(crate) fn winding(&self) -> &Winding {
        self.protection.winding()
    }

    /// Whether the heat of the winding or a weak supply reduces the current.
    pub(crate) fn is_derated(&self, limits: &MotorLimits) -> bool {
        self.current_limit.is_reduced(limits, self.winding())
    }

    /// The voltage at the resistance of the winding that makes a torque, in thousandths of the
    /// rated one; mV.
    pub(crate) fn torque_mv(&self, limits: &MotorLimits, permille: i16) -> i32 {
        limits.resistive_mv(permille, self.winding())
    }

    /// The operating state.
    pub fn state(&self) -> BoardState {
        self.state
    }

    /// The latched faults.
    pub fn latched(&self) -> &LatchedFaults {
        &self.latched
    }

    /// The outputs of the last control period.
    pub fn outputs(&self) -> &Outputs {
        &self.outputs
    }

    /// The same, for what the loop adds to them.
    pub(crate) fn outputs_mut(&mut self) -> &mut Outputs {
        &mut self.outputs
    }

    /// Measurements and state of the last control period.
    pub fn telemetry(&self) -> &Telemetry {
        &self.outputs.telemetry
    }

    /// The velocity that is reported, mdeg/s.
    pub fn velocity_mdeg_s(&self) -> i32 {
        self.velocity.mdeg_s()
    }

    /// The source of commands that is in force.
    pub fn source(&self) -> CommandSource {
        self.setpoints.source()
    }

    /// The source that is in force when no excitation runs.
    pub fn selected_source(&self) -> CommandSource {
        self.setpoints.selected()
    }

    /// Whether the motor is not driven, or a quick stop has brought the shaft to rest or has lasted
    /// its time.
    pub(crate) fn has_stopped(&self, settings: &StopSettings) -> bool {
        match self.state {
            BoardState::QuickStop | BoardState::FaultHold => self.stopping.is_late(settings),
            state => !state.is_driving(),
        }
    }

    /// One control period.
    pub fn control_period(&mut self, settings: Settings<'_>, samples: &Samples) -> &Outputs {
        let parameters = settings.board;
        self.outputs.telemetry.tick = self.outputs.telemetry.tick.wrapping_add(1);
        self.count_missed(samples.missed_periods);
        let shaft = self.control.shaft();
        let measured = (self.protection).measure(settings, samples, shaft, self.compare);
        self.update_telemetry(samples, &measured);
        if !self.control.shaft().is_known() {
            self.velocity.reset();
        }
        match measured.rate_change_mdeg_s {
            Some(mdeg_s) if settings.observes_rate => {
                let change = rate_of_mdeg_s(mdeg_s);
                (self.control).observe_change(&parameters.control, measured.count, change);
            }
            _ => (self.control).observe(&parameters.control, measured.count),
        }
        self.control.correct(settings.encoder);
        let angle = measured.count.map(|_| self.control.angle());
        self.velocity.step(angle, samples.missed_periods);
        let setpoint = self.setpoints.next(
            (&parameters.command, &parameters.servo),
            samples.servo_pulse_us,
            self.control.angle(),
        );
        self.protect(settings, samples, &measured, setpoint);
        self.regulate(settings, &measured, setpoint);
        self.report(parameters);
        &self.outputs
    }

    /// The rate of the command, mdeg/s, and the mean voltage that the motor needs for it, mV, in
    /// this control period.
    pub(crate) fn feed_forward(&mut self, rate_mdeg_s: i32, voltage_mv: i32) {
        self.feed_forward.demand(rate_mdeg_s, voltage_mv);
    }

    /// The last step ended too late: its duty took effect one update period after it was due. That
    /// counts as a missed control period, but no sample was lost.
    pub fn was_late(&mut self) {
        self.is_late = true;
    }

    /// Control periods that did not run: the next difference of counts spans them.
    fn count_missed(&mut self, periods: u8) {
        let missed = u32::from(periods);
        self.outputs.telemetry.missed_periods =
            self.outputs.telemetry.missed_periods.saturating_add(missed);
        self.control.miss(periods.into());
    }

    fn update_telemetry(&mut self, samples: &Samples, measured: &Measured) {
        let t = &mut self.outputs.telemetry;
        t.bus = samples.bus;
        t.current_ma = measured
            .current
            .map_or(t.current_ma, |current| current.mean_ma);
        t.sampled_ma = measured.sampled_ma.unwrap_or(t.sampled_ma);
        t.back_emf_mv = measured.back_emf_mv.unwrap_or(t.back_emf_mv);
        t.supply_mv = measured.supply_mv.unwrap_or(t.supply_mv);
        t.temperature_mdeg_c = measured.temperature_mdeg_c.unwrap_or(t.temperature_mdeg_c);
        t.magnet = measured.magnet.unwrap_or(t.magnet);
    }

    fn protect(
        &mut self,
        settings: Settings<'_>,
        samples: &Samples,
        measured: &Measured,
        setpoint: Setpoint,
    ) {
        let parameters = settings.board;
        let gains = &parameters.control;
        let conditions = Conditions {
            measured,
            is_driving: self.state.is_driving(),
            is_following: self.state == BoardState::Enabled,
            angle: self.control.angle(),
            rate: self.control.rate(),
            setpoint: match setpoint.angle() {
                Some(angle) => gains.reachable(angle).into(),
                None => setpoint,
            },
            rate_command: self.last_step.rate_command,
            duty: self.last_step.duty,
            is_stale: self.state == BoardState::Enabled
                && self.setpoints.is_stale(&parameters.command),
            is_bus_lost: samples.bus == BusState::Off
                && self.setpoints.selected() == CommandSource::Bus,
            is_tripped: samples.bridge_tripped,
            missed_periods: samples
                .missed_periods
                .saturating_add(u8::from(core::mem::take(&mut self.is_late))),
        };
        let present = self.protection.check(settings, &conditions);
        let present = present.or(self.start.and(PERMANENT));
        let t = &mut self.outputs.telemetry;
        t.present = present;
        t.counter = self.protection.counter(Counter::of_tick(t.tick));
        match self.state {
            BoardState::Initialising => {
                let turns = self.turns_at_start(measured);
                self.initialise(parameters, present, turns);
            }
            _ => self.react(parameters, present),
        }
    }

    /// Whether the shaft turns when the board starts: by the back-EMF, which may have an offset,
    /// and after 40 ms by the encoder; without a count for a second at most.
    fn turns_at_start(&self, measured: &Measured) -> bool {
        let tick = self.outputs.telemetry.tick;
        let moves = (measured.back_emf_mv).is_some_and(|mv| !back_emf_brake::stands(mv));
        let encoder_moves = match measured.count {
            Some(_) => !stopping::stands(self.control.rate()),
            None => tick < ENCODER_LOST_PERIODS,
        };
        let is_first = tick < ENCODER_SETTLED_PERIODS;
        moves && (is_first || encoder_moves)
    }

    /// Ends the initialisation when everything is measured and the shaft does not turn, or a fault
    /// of the start is to be latched.
    fn initialise(&mut self, parameters: &BoardParameters, present: FaultSet, turns: bool) {
        let urgent = present.and(ALWAYS);
        let is_measured = self.control.shaft().is_known() && self.protection.is_complete();
        let is_early = self.outputs.telemetry.tick < INITIALISING_PERIODS;
        let is_waiting = if !urgent.is_empty() {
            false
        } else if is_measured {
            turns && self.start.is_empty()
        } else {
            is_early
        };
        if is_waiting {
            return;
        }
        let mut faults = self.start.or(urgent);
        if !is_measured && urgent.is_empty() {
            faults = faults.or(present);
            faults.put(Fault::EncoderInvalid, !self.control.shaft().is_known());
            faults.put(Fault::MeasurementLost, !self.protection.is_complete());
        }
        self.state = BoardState::Disabled;
        self.latch(parameters, faults);
    }

    /// Latches the present faults that are relevant in this state.
    fn react(&mut self, parameters: &BoardParameters, present: FaultSet) {
        let is_free = !self.state.is_driving() || self.back_emf_stop.is_some();
        if is_free && !present.and(POSITION_LOST).is_empty() {
            self.control.reset_position();
        }
        let relevant = match self.state {
            BoardState::Enabled => present,
            BoardState::QuickStop | BoardState::FaultReaction | BoardState::FaultHold => {
                present.without(OF_COMMANDS)
            }
            _ => present.and(ALWAYS),
        };
        self.latch(parameters, relevant);
    }

    fn latch(&mut self, parameters: &BoardParameters, faults: FaultSet) {
        for fault in faults.without(self.latched.all()).iter() {
            self.latched.latch(fault);
            match (reaction(parameters, fault), self.state) {
                (Reaction::QuickStop, BoardState::Enabled) => self.stop(BoardState::FaultReaction),
                // The ramp has ended: the shaft is held, or a load turns it.
                (Reaction::QuickStop, BoardState::QuickStop)
                    if self.stopping.holds_at().is_some() =>
                {
                    self.stop(BoardState::FaultReaction)
                }
                // The ramp is already running, or the shaft is held after it.
                (Reaction::QuickStop, BoardState::QuickStop | BoardState::FaultHold) => {
                    self.state = BoardState::FaultReaction
                }
                (Reaction::QuickStop, BoardState::FaultReaction) => {}
                (Reaction::StopByBackEmf, state) if state.is_driving() => {
                    self.stop_by_back_emf();
                    self.state = BoardState::FaultReaction;
                }
                _ => self.state = BoardState::Fault,
            }
        }
    }

    fn report(&mut self, parameters: &BoardParameters) {
        self.outputs.bridge = self.bridge(parameters);
        self.outputs.state = self.state;
        self.outputs.fault = self.latched.first();
        let t = &mut self.outputs.telemetry;
        t.angle = self.control.angle();
        t.rate = self.control.rate();
        t.command = self.setpoints.command();
        t.rate_command = self.last_step.rate_command;
        t.duty = self.last_step.duty;
        t.limits = self.last_step.limits;
        t.winding = Single::new(self.protection.winding().deg_c());
        t.servo_pulse_us = self.setpoints.servo_pulse_us();
        t.servo_glitches = self.setpoints.servo_glitches();
        t.source = self.setpoints.source();
        t.selected_source = self.setpoints.selected();
        t.velocity_mdeg_s = self.velocity.mdeg_s();
        t.latched = self.latched.all();
    }
}

/// The outputs before the first control period. Not inlined: they are then written where they stay.
#[inline(never)]
fn no_outputs(taken: Taken) -> Outputs {
    Outputs {
        taken,
        ..Outputs::default()
    }
}

/// The reaction to a fault. Only where the motor may brake is it stopped by its back-EMF.
fn reaction(parameters: &BoardParameters, fault: Fault) -> Reaction {
    match fault.reaction() {
        Reaction::StopByBackEmf if !parameters.braking_faults().contains(fault) => {
            Reaction::SwitchOff
        }
        reaction => reaction,
    }
}

#[cfg(test)]
pub(crate) mod tests;
