//! Values that code of the drive reads and writes: commands and orders.

use canopen::{
    Abort,
    cia402::{Mode, statusword},
};

use super::Drive;
use crate::{
    application::{BoardState, CommandSource},
    capture::{CaptureSettings, Signal, Trigger},
    control_loop::{Command, ExcitationRequest, PERIOD_US, Polarity, Targets, ends_motion},
    dictionary::{DriveCommand, Measured},
    parameters::{ExcitationSettings, ObjectValue, Parameter},
    timing::thousandths,
};

/// Shape of the excitation that is a sum.
const MULTISINE: i32 = 9;

/// The number of a capture signal that selects none.
const NO_SIGNAL: u8 = 255;

/// Codes of 6007h and the actions of 2040h:2.
const ABORT_CONNECTION: [(i32, u8); 6] = [(-2, 2), (-1, 0), (0, 3), (1, 1), (2, 4), (3, 5)];

/// Longest time between two outputs of the loop that counts, us.
const MOST_US: u32 = 1_000_000;

impl Drive<'_> {
    /// The present value of a command.
    pub(super) fn command_value(&self, command: DriveCommand) -> u64 {
        use super::measured::signed;
        let commands = self.messages.commands.unverified();
        let (newest, targets) = (commands.newest(), &commands.targets);
        let sign = Polarity::of(&self.values);
        let position = |mdeg: i32| signed(mdeg.wrapping_mul(sign.position));
        let velocity = |mdeg_s: i32| signed(mdeg_s.wrapping_mul(sign.velocity));
        let torque = |permille: i16| signed(i32::from(permille) * sign.velocity);
        match command {
            DriveCommand::CommandSource => self.selected_source() as u64,
            DriveCommand::ExcitationControl => self.measured(Measured::ExcitationStatus),
            DriveCommand::CaptureControl => u64::from(matches!(self.capture.phase() as u8, 1 | 2)),
            // The program is running.
            DriveCommand::ProgramControl => 1,
            DriveCommand::DownloadOffset => u64::from(self.download_offset()),
            // Write only.
            DriveCommand::ServicePassword | DriveCommand::ClearPoints => 0,
            DriveCommand::Controlword => u64::from(newest.control),
            DriveCommand::Mode => signed(i32::from(newest.mode as i8)),
            DriveCommand::TargetPosition => position(targets.position),
            DriveCommand::PositionOffset => position(targets.offset),
            DriveCommand::InterpolationPoint => position(self.points.last),
            DriveCommand::TargetVelocity => velocity(newest.target_velocity_mdeg_s),
            DriveCommand::VelocityOffset => velocity(newest.velocity_offset_mdeg_s),
            DriveCommand::TargetTorque => torque(targets.torque),
            DriveCommand::TorqueOffset => torque(targets.torque_offset),
            DriveCommand::TouchProbe => u64::from(self.touch_probes.function()),
            DriveCommand::Commissioning => u64::from(self.commissioning),
            DriveCommand::AbortConnection => signed(self.abort_connection()),
        }
    }

    /// Executes a command.
    pub(super) fn execute(&mut self, command: DriveCommand, value: u64) -> Result<(), Abort> {
        if self.is_on_servo_bus && commands_motion(command, value) {
            return Err(Abort::LocalControl);
        }
        self.is_stopped |= self.is_on_servo_bus && command == DriveCommand::Controlword;
        match command {
            DriveCommand::CommandSource => self.switch_source(value),
            DriveCommand::ExcitationControl if value == 0 => {
                self.messages.excitation.update(ExcitationRequest::stop);
            }
            DriveCommand::ExcitationControl => return self.start_excitation(),
            DriveCommand::CaptureControl if value == 0 => self.capture.stop(),
            DriveCommand::CaptureControl => self.arm_capture(),
            DriveCommand::ProgramControl => return self.install(),
            DriveCommand::DownloadOffset => return self.update.set_next_offset(value as u32),
            DriveCommand::ServicePassword => {
                let password = self.values.service.password;
                return self.service.attempt(value as u32, password);
            }
            DriveCommand::TouchProbe => return self.touch_probes.set(value as u16),
            DriveCommand::Commissioning => self.commissioning = value as u8,
            DriveCommand::ClearPoints if value == 0 => self.points.clear(),
            DriveCommand::ClearPoints => {}
            DriveCommand::AbortConnection => return self.set_abort_connection(value as i32),
            DriveCommand::InterpolationPoint => return self.append_point(value as i32),
            DriveCommand::Controlword
            | DriveCommand::Mode
            | DriveCommand::TargetPosition
            | DriveCommand::PositionOffset
            | DriveCommand::TargetVelocity
            | DriveCommand::VelocityOffset
            | DriveCommand::TargetTorque
            | DriveCommand::TorqueOffset => return self.command(command, value),
        }
        Ok(())
    }

    /// Changes the command to the loop. While too many are queued, an SDO waits and an RPDO is
    /// refused.
    fn command(&mut self, object: DriveCommand, value: u64) -> Result<(), Abort> {
        let commands = self.messages.commands.unverified();
        let before = *commands.newest();
        let (mut command, mut targets) = (before, commands.targets);
        let sign = Polarity::of(&self.values);
        let position = (value as i32).saturating_mul(sign.position);
        let velocity = (value as i32).saturating_mul(sign.velocity);
        let torque = (value as i16).saturating_mul(sign.velocity as i16);
        match object {
            DriveCommand::Controlword => command.control = value as u16,
            DriveCommand::Mode => {
                command.mode = Mode::from_code(value as i8).ok_or(Abort::Value)?;
                let target = targets.position_of_mode(command.mode);
                command.target_position_mdeg = target.unwrap_or(command.target_position_mdeg);
                command.target_torque_permille = targets.torque_of_mode(command.mode);
            }
            DriveCommand::TargetPosition => targets.position = position,
            DriveCommand::PositionOffset => targets.offset = position,
            DriveCommand::TargetTorque => targets.torque = torque,
            DriveCommand::TorqueOffset => targets.torque_offset = torque,
            DriveCommand::TargetVelocity => command.set_velocity(velocity),
            _ => command.set_velocity_offset(velocity),
        }
        match object {
            DriveCommand::TargetPosition | DriveCommand::PositionOffset => {
                let target = targets.position_of_mode(command.mode);
                target.into_iter().for_each(|it| command.set_position(it));
            }
            DriveCommand::TorqueOffset if !command.mode.is_cyclic() => {}
            DriveCommand::TargetTorque | DriveCommand::TorqueOffset => {
                command.set_torque(targets.torque_of_mode(command.mode));
            }
            _ => {}
        }
        self.post_command(&command, &targets)?;
        // Not by the same mode again, which an RPDO repeats with each point.
        if command.mode != before.mode {
            self.points.clear();
        }
        Ok(())
    }

    /// Whether the loop has still to take a command.
    pub(super) fn has_waiting_command(&self) -> bool {
        self.outputs.taken.command != self.messages.commands.unverified().number()
    }

    /// Posts a command, made from these targets.
    fn post_command(&mut self, command: &Command, targets: &Targets) -> Result<(), Abort> {
        let before = self.messages.commands.unverified().number();
        let (taken, joins) = (self.outputs.taken.command, self.has_queued);
        let commands = &mut self.messages.commands;
        let mut is_accepted = true;
        commands.update(|it| {
            is_accepted = it.set(command, joins, taken);
            if is_accepted {
                it.targets = *targets;
            }
        });
        self.has_queued |= commands.unverified().number() != before;
        is_accepted.then_some(()).ok_or(Abort::NoResource)
    }

    /// Appends a point to those of the interpolated position mode. While the buffer is full, an SDO
    /// waits and an RPDO is refused.
    fn append_point(&mut self, point: i32) -> Result<(), Abort> {
        let position = point.saturating_mul(Polarity::of(&self.values).position);
        let is_accepted = self.points.append(position);
        is_accepted.then_some(()).ok_or(Abort::NoResource)
    }

    /// Posts the point that is due while the loop interpolates.
    pub(super) fn post_point(&mut self, passed_periods: u32) {
        let motion = &self.outputs.motion;
        let interpolates =
            motion.mode == Mode::InterpolatedPosition && motion.status & statusword::MODE_12 != 0;
        if !interpolates || passed_periods == 0 {
            return;
        }
        let commands = self.messages.commands.unverified();
        let (command, targets) = (*commands.newest(), commands.targets);
        if self.has_waiting_command() || command.mode != Mode::InterpolatedPosition {
            return;
        }
        let passed_us = passed_periods.saturating_mul(PERIOD_US).min(MOST_US) as i32;
        let period_us = i32::from(self.values.profile.interpolation_time) * 1000;
        if let Some(point) = self.points.next(passed_us, period_us) {
            let mut command = command;
            command.set_position(point);
            // Nothing is queued: there is room.
            let _ = self.post_command(&command, &targets);
        }
    }

    /// 6007h: the action 2040h:2 by the codes of CiA 402.
    fn abort_connection(&self) -> i32 {
        let action = self.values.failsafe.failsafe_action;
        let code = ABORT_CONNECTION.iter().find(|(_, of)| *of == action);
        code.map_or(0, |(code, _)| *code)
    }

    fn set_abort_connection(&mut self, code: i32) -> Result<(), Abort> {
        let action = ABORT_CONNECTION.iter().find(|(of, _)| *of == code);
        let (_, action) = action.ok_or(Abort::Value)?;
        self.set_value(ObjectValue::FailsafeAction, u32::from(*action))
    }

    /// Switches the source of the commands. At standstill it is the source after a reset too, once
    /// it is stored.
    fn switch_source(&mut self, value: u64) {
        let source = if value == 1 {
            CommandSource::ServoPulse
        } else {
            CommandSource::Bus
        };
        self.messages.commands.update(|it| it.select(source));
        // Refused while the loop is closed: only gains change then.
        let _ = self.set_parameter(Parameter::CommandSource, value as u32);
    }

    /// Starts the excitation behind the commands that were written before: an SDO waits until the
    /// loop has taken them, and an RPDO is refused.
    fn start_excitation(&mut self) -> Result<(), Abort> {
        if self.has_waiting_command() {
            return Err(Abort::NoResource);
        }
        let settings = self.values.excitation;
        let run = settings.run().ok_or(Abort::Incompatible)?;
        if !self.has_room(&settings) {
            return Err(Abort::Incompatible);
        }
        if self.outputs.state != BoardState::Enabled {
            return Err(Abort::DeviceState);
        }
        self.messages.excitation.update(|it| it.start(run));
        Ok(())
    }

    /// Whether the command stays within the position limits 607Dh during this excitation.
    fn has_room(&self, settings: &ExcitationSettings) -> bool {
        // In the worst case the lines of a multisine add up.
        let lines = if settings.shape == MULTISINE {
            settings.lines
        } else {
            1
        };
        let reach = settings
            .amplitude_mdeg
            .saturating_abs()
            .saturating_mul(lines);
        let origin = self.outputs.motion.origin_mdeg;
        let from = thousandths(self.outputs.telemetry.command).saturating_add(origin);
        let limits = self.messages.parameters.unverified().axis.position_limits;
        limits.is_none_or(|(low, high)| {
            from.saturating_sub(reach) >= low && from.saturating_add(reach) <= high
        })
    }

    fn arm_capture(&mut self) {
        self.update.forget_beginning();
        let settings = &self.values.capture;
        let signals = [
            settings.signal_1,
            settings.signal_2,
            settings.signal_3,
            settings.signal_4,
            settings.signal_5,
            settings.signal_6,
            settings.signal_7,
            settings.signal_8,
        ];
        self.capture.arm(CaptureSettings {
            signals: signals.map(Signal::of_number),
            decimation: settings.decimation,
            trigger: match settings.trigger {
                1 => Trigger::Excitation,
                2 => Trigger::Fault,
                _ => Trigger::Now,
            },
            before: settings.pre_trigger_records,
        });
    }
}

/// Whether a write commands motion, and does not end it.
fn commands_motion(command: DriveCommand, value: u64) -> bool {
    match command {
        DriveCommand::Controlword => !ends_motion(value as u16),
        DriveCommand::ExcitationControl => value != 0,
        DriveCommand::Mode
        | DriveCommand::CommandSource
        | DriveCommand::InterpolationPoint
        | DriveCommand::TargetPosition
        | DriveCommand::PositionOffset
        | DriveCommand::TargetVelocity
        | DriveCommand::VelocityOffset
        | DriveCommand::TargetTorque
        | DriveCommand::TorqueOffset => true,
        DriveCommand::CaptureControl
        | DriveCommand::ProgramControl
        | DriveCommand::DownloadOffset
        | DriveCommand::ServicePassword
        | DriveCommand::TouchProbe
        | DriveCommand::Commissioning
        | DriveCommand::ClearPoints
        | DriveCommand::AbortConnection => false,
    }
}

/// Whether this number selects a capture signal, or none.
pub(super) fn is_signal(number: u32) -> bool {
    let is_known = |number| number == NO_SIGNAL || Signal::of_number(number).is_some();
    u8::try_from(number).is_ok_and(is_known)
}
