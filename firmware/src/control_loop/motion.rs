//! The axis and the application: demands one way, state and motion the other, once in each control
//! period.

use canopen::cia402::{
    self, Cia402State, Command, Demand, Input, Mode, Offsets, Output, Parameters as AxisParameters,
    StopOption, controlword, statusword,
};

use model_core::control::cascade::Setpoint;

use super::{LoopParameters, State, Written, failsafe::Reaction, feed_forward::Demanded};
use crate::{
    application::{BoardState, CommandSource, Refused, Request, TorqueSetpoint},
    faults::{Fault, FaultSet},
    interface::Motion,
    timing::{angle_of_mdeg, rate_of_mdeg_s, thousandths},
};

/// Faults of the supply voltage.
const VOLTAGE: FaultSet = FaultSet::of(&[Fault::UnderVoltage, Fault::OverVoltage]);

/// The fault that a held load causes.
const STALL: FaultSet = FaultSet::of(&[Fault::Stall]);

impl State {
    /// A rising edge of the fault reset acknowledges faults that are no longer present, in the
    /// state "fault" alone: transition 15.
    pub(super) fn acknowledge(&mut self) {
        let resets = self.command.control & controlword::FAULT_RESET != 0;
        let before = core::mem::replace(&mut self.motion().resets, resets);
        let rises = resets && !before;
        // A load that is held stalls the motor until the reset.
        let present = self.application.telemetry().present.without(STALL);
        let has_stopped = self.axis.state() == Cia402State::Fault;
        if !rises || !has_stopped || !present.and(self.latched()).is_empty() {
            return;
        }
        if self.has_failed() {
            // The state allows it.
            let _ = self.application.request(Request::Acknowledge);
        }
        if self.application.state() != BoardState::FaultReaction && !self.command_faults.is_empty()
        {
            self.command_faults = FaultSet::EMPTY;
            self.failsafe.begin_anew();
        }
    }

    /// One period of the axis.
    pub(super) fn step_axis(&mut self, parameters: &LoopParameters, written: Written) -> Output {
        if !self.is_commanded() {
            // Start from the command while the loop is closed, so that taking over is no step.
            let command = match self.application.state() {
                BoardState::Enabled => self.application.telemetry().command,
                _ => self.application.telemetry().angle,
            };
            // Only a stop starts from the rate.
            let runs = Command::from_controlword(self.command.control) == Command::EnableOperation;
            let rate_mdeg_s = if runs { 0 } else { self.rate_mdeg_s() };
            self.axis.reset_demand(thousandths(command), rate_mdeg_s);
        }
        let input = self.input(parameters, written);
        let of_encoder = input.position_actual;
        let output = self.axis.step(input, &parameters.axis);
        let mut status = output.statusword;
        let limits = self.application.telemetry().limits;
        let is_torque = matches!(output.demand, Demand::Torque { .. });
        if limits.current || is_torque && limits.rate {
            status |= statusword::INTERNAL_LIMIT;
        }
        if self.application.is_derated(&parameters.limits) {
            status |= statusword::WARNING;
        }
        let actual = of_encoder.saturating_add(output.origin);
        let (position_mdeg, velocity_mdeg_s, torque_permille) = match output.demand {
            Demand::Off => (actual, 0, 0),
            Demand::Position { position, velocity } => (position, velocity, 0),
            Demand::Velocity(velocity) => (actual, velocity, 0),
            Demand::Torque { torque, .. } => (actual, self.rate_mdeg_s(), torque),
        };
        let motion = self.motion();
        *motion = Motion {
            state: output.state,
            status,
            mode: output.mode_display,
            position_mdeg,
            velocity_mdeg_s,
            torque_permille,
            following_error_mdeg: output.following_error,
            origin_mdeg: output.origin,
            is_powered: output.demand != Demand::Off,
            resets: motion.resets,
        };
        output
    }

    fn input(&mut self, parameters: &LoopParameters, written: Written) -> Input {
        let mut input = Input {
            controlword: self.command.control,
            mode: self.command.mode,
            target_position: self.command.target_position_mdeg,
            target_velocity: self.command.target_velocity_mdeg_s,
            velocity_offset: self.command.velocity_offset_mdeg_s,
            target_torque: self.command.target_torque_permille,
            is_new_position: written.position,
            is_new_velocity: written.velocity,
            is_new_torque: written.torque,
            position_actual: self.angle_mdeg(),
            velocity_actual: self.application.velocity_mdeg_s(),
            current_actual: self.application.telemetry().current_ma,
            fault: self.fault(),
            voltage: self.application.telemetry().present.and(VOLTAGE).is_empty(),
            initialised: self.application.state() != BoardState::Initialising,
        };
        match self.fail_safe(parameters) {
            Reaction::None => {}
            Reaction::Fail => {
                self.command_faults.put(Fault::CommandTimeout, true);
                input.fault = self.fault();
            }
            Reaction::Control(word) => input.controlword = word,
            Reaction::Go(position_mdeg) => {
                input.mode = Mode::CyclicPosition;
                input.target_position = position_mdeg;
                input.is_new_position = true;
            }
        }
        input
    }

    fn fault(&self) -> cia402::Fault {
        match self.application.state() {
            BoardState::Fault | BoardState::FaultHold => cia402::Fault::Immediate,
            BoardState::FaultReaction => cia402::Fault::Controlled,
            _ if self.command_faults.is_empty() => cia402::Fault::None,
            // The application has no fault: it can decelerate the shaft.
            state if state.is_driving() => cia402::Fault::Controlled,
            _ => cia402::Fault::Immediate,
        }
    }

    /// Requests from the application what the axis demands.
    pub(super) fn apply_demand(&mut self, parameters: &LoopParameters, output: &Output) {
        let offsets = self.offsets(parameters);
        if !parameters.forward.is_off() || offsets != Offsets::default() {
            match output.demand {
                Demand::Position { velocity, .. } | Demand::Velocity(velocity) => {
                    let is_cyclic = output.mode_display.is_cyclic();
                    self.feed_forward(parameters, (velocity, is_cyclic), offsets);
                }
                Demand::Off | Demand::Torque { .. } => self.demanded = Demanded::default(),
            }
        }
        match output.demand {
            Demand::Off => self.power_off(&parameters.axis, output.state),
            Demand::Position { position, .. } => {
                let of_encoder = position.saturating_sub(output.origin);
                let setpoint = Setpoint::Angle(angle_of_mdeg(of_encoder));
                self.command(output.state, Request::Command(setpoint));
            }
            Demand::Velocity(velocity) => {
                let setpoint = Setpoint::Rate(rate_of_mdeg_s(velocity));
                self.command(output.state, Request::Command(setpoint));
            }
            Demand::Torque { torque, velocities } => {
                let setpoint = TorqueSetpoint {
                    permille: torque,
                    rates_mdeg_s: velocities,
                };
                self.command(output.state, Request::Torque(setpoint));
            }
        }
    }

    /// The commanded offsets in effect. That of the velocity belongs to the targets of the master:
    /// it is zero on the way to the failsafe position.
    fn offsets(&self, parameters: &LoopParameters) -> Offsets {
        let wanted = Offsets {
            velocity: self.command.velocity_offset_mdeg_s,
            torque: self.command.target_torque_permille,
        };
        if wanted == Offsets::default() {
            return wanted;
        }
        let mut offsets = self.axis.offsets(wanted, &parameters.axis);
        if self.failsafe.retreats() {
            offsets.velocity = 0;
        }
        offsets
    }

    /// Feeds a demanded velocity and the offsets forward while the commands of the mailbox are
    /// followed: as a rate that is added to that of the position loop, and as the voltage that the
    /// motor needs.
    #[inline(never)]
    fn feed_forward(
        &mut self,
        parameters: &LoopParameters,
        (mdeg_s, is_cyclic): (i32, bool),
        offsets: Offsets,
    ) {
        let gains = &parameters.forward;
        let voltage_mv = (self.demanded).next(gains, mdeg_s, is_cyclic);
        if self.is_commanded() {
            let rate_mdeg_s = gains.velocity(mdeg_s).saturating_add(offsets.velocity);
            let torque_mv = (self.application).torque_mv(&parameters.limits, offsets.torque);
            self.application
                .feed_forward(rate_mdeg_s, voltage_mv + torque_mv);
        }
    }

    fn power_off(&mut self, axis: &AxisParameters, state: Cia402State) {
        // The application decelerates and holds the shaft by itself, unless power must be removed
        // at once.
        let coasts = axis.options.fault_reaction == StopOption::Disable;
        let reacts = matches!(
            self.application.state(),
            BoardState::FaultReaction | BoardState::FaultHold
        ) && state == Cia402State::Fault
            && !coasts;
        if self.application.state().is_driving() && !reacts {
            let _ = self.application.request(Request::Disable);
        }
    }

    fn command(&mut self, state: Cia402State, request: Request) {
        let runs = state == Cia402State::OperationEnabled;
        if runs
            && matches!(
                self.application.state(),
                BoardState::Disabled | BoardState::QuickStop
            )
        {
            match self.application.request(Request::Enable) {
                Ok(()) => {}
                Err(Refused::Blocked(fault)) => self.command_faults.put(fault, true),
                // The state has changed meanwhile: the next period handles it.
                Err(_) => {}
            }
        }
        if self.is_commanded() {
            let _ = self.application.request(request);
        } else if !runs && self.application.state() == BoardState::Enabled {
            // A stop ends the commands of every other source.
            let _ = match self.application.source() {
                CommandSource::Excitation => self.application.request(Request::StopExcitation),
                _ => self.application.request(Request::QuickStop),
            };
        }
    }

    pub(super) fn angle_mdeg(&self) -> i32 {
        thousandths(self.application.telemetry().angle)
    }

    fn rate_mdeg_s(&self) -> i32 {
        thousandths(self.application.telemetry().rate)
    }
}
