//! One control period of the board, and its operating states.
//!
//! | from | to | when |
//! |---|---|---|
//! | initialising | disabled | encoder, current, supply and temperature were measured |
//! | initialising | fault | they were not within 200 ms; or the reset was the watchdog's; or the stored parameters were corrupt |
//! | disabled | enabled | [`Request::Enable`], and nothing is wrong |
//! | enabled | disabled | [`Request::Disable`] |
//! | enabled | quick stop | [`Request::QuickStop`] |
//! | quick stop | disabled | the shaft has come to rest and is not to be held; `quick_stop_ms` is over; [`Request::Disable`] |
//! | quick stop | enabled | [`Request::Enable`] |
//! | enabled, quick stop | fault reaction | a fault whose reaction is a quick stop |
//! | fault reaction | fault | the shaft has come to rest; `quick_stop_ms` is over; [`Request::Disable`] |
//! | any | fault | a fault whose reaction is to coast |
//! | fault | disabled | [`Request::Acknowledge`] |
//!
//! While the bridge is off, what would be a fault is none: it stands in [`Telemetry::present`] and
//! blocks [`Request::Enable`]. Only what is lost otherwise is latched in any state: a trip of the
//! bridge, missed control periods, corrupt parameters and a reset by the watchdog.
//!
//! Order of a control period: measure, judge the encoder's word, observe, command, protect, change
//! the state, regulate.

mod requests;
mod stopping;

use model_core::control::{cascade, encoder_word::EncoderWord, units::Angle};

pub use crate::interface::{
    BoardState, Bridge, BusState, CommandSource, Outputs, Refused, Request, Samples, Scan,
    Telemetry,
};

use self::stopping::Stopping;
use crate::{
    command::SetpointSource,
    faults::{ALWAYS, Fault, FaultLog, FaultSet, OF_COMMANDS, Reaction},
    parameters::BoardParameters,
    protection::{Conditions, Measured, Protection},
    timing::periods,
};

/// Control periods within which everything has to be measured after a reset: the AS5045 takes up to
/// 80 ms to its first angle (data sheet, power-up time).
const INITIALISING_PERIODS: u32 = periods(200) as u32;

/// The angle is lost: a word that comes later may be a turn away.
const LOST: FaultSet =
    FaultSet::of(&[Fault::EncoderInvalid, Fault::MagnetLost, Fault::EncoderJump]);

/// How a reset left the board, as far as the application minds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Start {
    /// The watchdog has reset it.
    pub watchdog: bool,
    /// There were stored parameters, and none of them could be read.
    pub parameters_corrupt: bool,
}

/// The application: parameters, and everything that it remembers.
#[derive(Debug, Clone)]
pub struct Application {
    parameters: BoardParameters,
    control: cascade::CascadeState,
    state: BoardState,
    held: cascade::CascadeStep,
    setpoints: SetpointSource,
    protection: Protection,
    stopping: Stopping,
    log: FaultLog,
    start: FaultSet,
    is_late: bool,
    telemetry: Telemetry,
}

impl Application {
    /// An application after an ordinary reset, with parameters that were checked.
    ///
    /// ```
    /// use firmware::{application::{Application, BoardState}, parameters::BoardParameters};
    ///
    /// assert_eq!(Application::new(BoardParameters::DEFAULT).state(), BoardState::Initialising);
    /// ```
    pub fn new(parameters: BoardParameters) -> Self {
        Self::after(parameters, Start::default())
    }

    /// An application after a reset of any kind; what went wrong before becomes a fault.
    ///
    /// ```
    /// use firmware::application::{Application, Start};
    /// use firmware::parameters::BoardParameters;
    ///
    /// let start = Start { watchdog: true, ..Start::default() };
    /// assert!(Application::after(BoardParameters::DEFAULT, start).faults().latched().is_empty());
    /// ```
    pub fn after(parameters: BoardParameters, start: Start) -> Self {
        let mut faults = FaultSet::EMPTY;
        faults.put(Fault::WatchdogReset, start.watchdog);
        faults.put(Fault::ParametersCorrupt, start.parameters_corrupt);
        Self {
            parameters,
            control: cascade::CascadeState::default(),
            state: BoardState::Initialising,
            held: cascade::CascadeStep::default(),
            setpoints: SetpointSource::new(&parameters.command),
            protection: Protection::default(),
            stopping: Stopping::default(),
            log: FaultLog::default(),
            start: faults,
            is_late: false,
            telemetry: Telemetry::default(),
        }
    }

    /// The operating state.
    pub fn state(&self) -> BoardState {
        self.state
    }

    /// The faults that are latched and that were.
    pub fn faults(&self) -> &FaultLog {
        &self.log
    }

    /// What was known of the actuator in the last control period.
    pub fn telemetry(&self) -> &Telemetry {
        &self.telemetry
    }

    /// Empties the history of faults.
    pub fn clear_fault_history(&mut self) {
        self.log.clear_history();
    }

    /// The parameters in force.
    pub fn parameters(&self) -> &BoardParameters {
        &self.parameters
    }

    /// The shaft may have turned by any angle: the next valid word is the first one.
    fn reset_position(&mut self) {
        self.control.reset_position();
        self.protection.reset_position();
    }

    /// One control period.
    pub fn step(&mut self, samples: &Samples) -> Outputs {
        self.telemetry.tick = self.telemetry.tick.wrapping_add(1);
        self.miss(samples.missed_periods);
        let measured = self.protection.measure(&self.parameters, samples);
        self.note(samples, &measured);
        let valid = self
            .control
            .observe(&self.parameters.control, measured.word)
            .is_ok();
        let command = self
            .setpoints
            .next(&self.parameters, samples.servo_pulse_us);
        self.protect(samples, &measured, command);
        self.regulate(valid, command);
        self.outputs(command)
    }

    /// The step before this one ended too late: its duty took effect a PWM period after it was due.
    /// That counts as a missed control period, but no sample was lost.
    pub fn was_late(&mut self) {
        self.is_late = true;
    }

    /// Periods that were missed are samples that were lost, for the rate is a difference over time.
    fn miss(&mut self, periods: u8) {
        let missed = u32::from(periods);
        self.telemetry.missed_periods = self.telemetry.missed_periods.saturating_add(missed);
        for _ in 0..periods.min(8) {
            let _ = self
                .control
                .observe(&self.parameters.control, EncoderWord::new(0));
        }
    }

    fn note(&mut self, samples: &Samples, measured: &Measured) {
        let t = &mut self.telemetry;
        t.bus = samples.bus;
        t.current_ma = measured.current_ma.unwrap_or(t.current_ma);
        t.back_emf_mv = measured.back_emf_mv.unwrap_or(t.back_emf_mv);
        t.supply_mv = measured.supply_mv.unwrap_or(t.supply_mv);
        t.temperature_mdeg_c = measured.temperature_mdeg_c.unwrap_or(t.temperature_mdeg_c);
        t.magnet = measured.magnet.unwrap_or(t.magnet);
    }

    fn protect(&mut self, samples: &Samples, measured: &Measured, command: Angle) {
        let conditions = Conditions {
            measured,
            is_driving: self.state.is_driving(),
            is_following: self.state == BoardState::Enabled,
            angle: self.control.angle(),
            rate: self.control.rate(),
            command: self.parameters.control.reachable(command),
            rate_command: self.held.rate_command,
            duty: self.held.duty,
            is_stale: self.state == BoardState::Enabled
                && self.setpoints.is_stale(&self.parameters.command),
            is_bus_lost: samples.bus == BusState::Off && self.setpoints.is_of_the_bus(),
            is_tripped: samples.bridge_tripped,
            missed_periods: samples
                .missed_periods
                .saturating_add(u8::from(core::mem::take(&mut self.is_late))),
        };
        let present = self.protection.check(&self.parameters, &conditions);
        self.telemetry.present = present;
        match self.state {
            BoardState::Initialising => self.initialise(present),
            _ => self.judge(present),
        }
    }

    fn initialise(&mut self, present: FaultSet) {
        let is_measured = self.control.is_position_known() && self.protection.is_complete();
        if !is_measured && self.telemetry.tick < INITIALISING_PERIODS {
            return;
        }
        let mut faults = self.start;
        if !is_measured {
            faults = faults.or(present);
            faults.put(Fault::EncoderInvalid, !self.control.is_position_known());
            faults.put(Fault::MeasurementLost, !self.protection.is_complete());
        }
        self.state = BoardState::Disabled;
        self.latch(faults);
    }

    /// Which of the present conditions matter in this state.
    fn judge(&mut self, present: FaultSet) {
        if !self.state.is_driving() && !present.and(LOST).is_empty() {
            self.reset_position();
        }
        self.latch(match self.state {
            BoardState::Enabled => present,
            BoardState::QuickStop | BoardState::FaultReaction => present.without(OF_COMMANDS),
            _ => present.and(ALWAYS),
        });
    }

    fn latch(&mut self, faults: FaultSet) {
        for fault in faults.without(self.log.latched()).iter() {
            self.log.latch(fault, self.telemetry.tick);
            match (fault.reaction(), self.state) {
                (Reaction::QuickStop, BoardState::Enabled) => self.stop(BoardState::FaultReaction),
                // The ramp is running already.
                (Reaction::QuickStop, BoardState::QuickStop) => {
                    self.state = BoardState::FaultReaction
                }
                (Reaction::QuickStop, BoardState::FaultReaction) => {}
                _ => self.state = BoardState::Fault,
            }
        }
    }

    fn regulate(&mut self, valid: bool, command: Angle) {
        if matches!(
            self.state,
            BoardState::QuickStop | BoardState::FaultReaction
        ) {
            self.decelerate(valid);
        } else if self.state == BoardState::Enabled && valid {
            self.held = self.control.regulate(&self.parameters.control, command);
        }
        if !self.state.is_driving() {
            self.control.release();
            self.held = cascade::CascadeStep::default();
        }
    }

    /// One period of a quick stop, and its end.
    fn decelerate(&mut self, valid: bool) {
        let BoardParameters {
            stop: settings,
            control: gains,
            ..
        } = &self.parameters;
        let may_hold = self.state == BoardState::QuickStop && settings.quick_stop_hold == 1;
        match self.stopping.holds_at().filter(|_| may_hold) {
            Some(_) if !valid => {}
            Some(angle) => self.held = self.control.regulate(gains, angle),
            None => {
                let command = self.stopping.next(settings, self.control.rate());
                if valid {
                    self.held = self.control.regulate_rate(gains, command);
                }
                if self.stopping.is_over(settings) {
                    match self.state {
                        _ if may_hold => self.stopping.hold(self.control.angle()),
                        BoardState::QuickStop => self.state = BoardState::Disabled,
                        _ => self.state = BoardState::Fault,
                    }
                }
            }
        }
    }

    fn outputs(&mut self, command: Angle) -> Outputs {
        let t = &mut self.telemetry;
        t.angle = self.control.angle();
        t.rate = self.control.rate();
        t.command = command;
        t.rate_command = self.held.rate_command;
        t.duty = self.held.duty;
        t.limits = self.held.limits;
        t.servo_pulse_us = self.setpoints.servo_pulse_us();
        t.servo_glitches = self.setpoints.servo_glitches();
        t.source = self.setpoints.source();
        t.latched = self.log.latched();
        Outputs {
            bridge: if self.state.is_driving() {
                Bridge::Driven(self.held.compare)
            } else {
                Bridge::Coast
            },
            state: self.state,
            fault: self.log.first().map(|record| record.fault),
            telemetry: self.telemetry,
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
