//! The axis and the application: demands one way, state and motion the other, once in each control
//! period.

use canopen::cia402::{self, Command, Demand, Input, Mode, Output, StopOption, controlword};

use model_core::control::cascade::Setpoint;

use super::{Drive, failsafe::Reaction};
use crate::{
    application::{BoardState, CommandSource, Refused, Request},
    faults::{Fault, FaultSet},
    timing::{angle_of_mdeg, rate_of_mdeg_s, thousandths},
};

/// State of the axis in the last control period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Motion {
    /// Statusword 6041h.
    pub statusword: u16,
    /// Modes of operation display 6061h.
    pub mode: i8,
    /// Position demand value 6062h, mdeg.
    pub position_mdeg: i32,
    /// Velocity demand value 606Bh, mdeg/s.
    pub velocity_mdeg_s: i32,
    /// Following error actual value 60F4h, mdeg.
    pub following_error_mdeg: i32,
    /// The axis demands power.
    pub is_powered: bool,
    /// Bit 7 of the controlword.
    resets: bool,
}

impl Default for Motion {
    fn default() -> Self {
        Self {
            statusword: 0,
            mode: 8,
            position_mdeg: 0,
            velocity_mdeg_s: 0,
            following_error_mdeg: 0,
            is_powered: false,
            resets: false,
        }
    }
}

/// Faults of the supply voltage.
const VOLTAGE: FaultSet = FaultSet::of(&[Fault::UnderVoltage, Fault::OverVoltage]);

impl Drive<'_> {
    /// A rising edge of the fault reset acknowledges faults that are no longer present.
    pub(super) fn acknowledge(&mut self) {
        let resets = self.commands.controlword & controlword::FAULT_RESET != 0;
        let rises = resets && !self.motion.resets;
        self.motion.resets = resets;
        let present = self.control.application.telemetry().present;
        if !rises || !present.and(self.latched()).is_empty() {
            return;
        }
        if self.has_failed() {
            // The state allows it.
            let _ = self.control.application.request(Request::Acknowledge);
        }
        if self.control.application.state() != BoardState::FaultReaction && !self.own.is_empty() {
            self.own = FaultSet::EMPTY;
            self.failsafe.begin_anew();
        }
    }

    /// One period of the axis.
    pub(super) fn step_axis(&mut self) -> Output {
        if !self.is_commanded() {
            // Start from the command while the loop is closed, so that taking over is no step.
            let command = match self.control.application.state() {
                BoardState::Enabled => self.control.application.telemetry().command,
                _ => self.control.application.telemetry().angle,
            };
            // Only a stop starts from the rate.
            let runs =
                Command::from_controlword(self.commands.controlword) == Command::EnableOperation;
            let rate_mdeg_s = if runs { 0 } else { self.rate_mdeg_s() };
            self.control
                .axis
                .reset_demand(thousandths(command), rate_mdeg_s);
        }
        let input = self.input();
        let control = &mut *self.control;
        let output = control.axis.step(&input, &control.axis_parameters);
        self.motion.statusword = output.statusword;
        self.motion.mode = output.mode_display as i8;
        self.motion.following_error_mdeg = output.following_error;
        self.motion.is_powered = output.demand != Demand::Off;
        (self.motion.position_mdeg, self.motion.velocity_mdeg_s) = match output.demand {
            Demand::Off => (self.angle_mdeg(), 0),
            Demand::Position { position, velocity } => (position, velocity),
            Demand::Velocity(velocity) => (self.angle_mdeg(), velocity),
        };
        output
    }

    fn input(&mut self) -> Input {
        let mut input = Input {
            controlword: self.commands.controlword,
            // Values between the modes that the dictionary's limits admit stop the axis.
            mode: Mode::from_code(self.commands.mode).unwrap_or(Mode::None),
            target_position: self.commands.target_position_mdeg,
            target_velocity: self.commands.target_velocity_mdeg_s,
            velocity_offset: self.commands.velocity_offset_mdeg_s,
            is_new_position: core::mem::take(&mut self.commands.is_new_position),
            is_new_velocity: core::mem::take(&mut self.commands.is_new_velocity),
            position_actual: self.angle_mdeg(),
            velocity_actual: self.control.application.velocity_mdeg_s(),
            fault: self.fault(),
            voltage: self
                .control
                .application
                .telemetry()
                .present
                .and(VOLTAGE)
                .is_empty(),
            initialised: self.control.application.state() != BoardState::Initialising,
        };
        match self.fail_safe() {
            Reaction::None => {}
            Reaction::Fail => {
                self.own.put(Fault::CommandTimeout, true);
                input.fault = self.fault();
            }
            Reaction::Hold => input.controlword |= controlword::HALT,
            Reaction::Go(position_mdeg) => {
                input.mode = Mode::CyclicPosition;
                input.target_position = position_mdeg;
                input.is_new_position = true;
            }
        }
        input
    }

    fn fault(&self) -> cia402::Fault {
        match self.control.application.state() {
            BoardState::Fault => cia402::Fault::Immediate,
            BoardState::FaultReaction => cia402::Fault::Controlled,
            _ if self.own.is_empty() => cia402::Fault::None,
            // The application has no fault: it can decelerate the shaft.
            state if state.is_driving() => cia402::Fault::Controlled,
            _ => cia402::Fault::Immediate,
        }
    }

    /// Requests from the application what the axis demands.
    pub(super) fn apply_demand(&mut self, output: &Output) {
        match output.demand {
            Demand::Off => self.power_off(output.state),
            Demand::Position { position, .. } => {
                self.command(output.state, angle_of_mdeg(position).into());
            }
            Demand::Velocity(velocity) => {
                self.command(output.state, rate_of_mdeg_s(velocity).into());
            }
        }
    }

    fn power_off(&mut self, state: cia402::Cia402State) {
        // The application decelerates the shaft by itself, unless power must be removed at once.
        let coasts = self.control.axis_parameters.options.fault_reaction == StopOption::Disable;
        let reacts = self.control.application.state() == BoardState::FaultReaction
            && state == cia402::Cia402State::Fault
            && !coasts;
        if self.control.application.state().is_driving() && !reacts {
            let _ = self.control.application.request(Request::Disable);
        }
    }

    fn command(&mut self, state: cia402::Cia402State, setpoint: Setpoint) {
        let runs = state == cia402::Cia402State::OperationEnabled;
        if runs
            && matches!(
                self.control.application.state(),
                BoardState::Disabled | BoardState::QuickStop
            )
        {
            match self.control.application.request(Request::Enable) {
                Ok(()) => {}
                Err(Refused::Blocked(fault)) => self.own.put(fault, true),
                // The state has changed meanwhile: the next period handles it.
                Err(_) => {}
            }
        }
        if self.is_commanded() {
            let _ = self.control.application.request(Request::Command(setpoint));
        } else if !runs && self.control.application.state() == BoardState::Enabled {
            // A stop ends the commands of every other source.
            let _ = match self.control.application.source() {
                CommandSource::Excitation => {
                    self.control.application.request(Request::StopExcitation)
                }
                _ => self.control.application.request(Request::QuickStop),
            };
        }
    }
}
