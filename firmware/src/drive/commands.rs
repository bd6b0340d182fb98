//! Values that code of the drive reads and writes: commands and orders.

use canopen::{Abort, cia402::Mode};

use super::Drive;
use crate::{
    application::{BoardState, CommandSource},
    capture::{CaptureSettings, Signal, Trigger},
    control_loop::ExcitationRequest,
    dictionary::{DriveCommand, Measured},
    parameters::{ExcitationSettings, Parameter},
    timing::thousandths,
};

/// Shape of the excitation that is a sum.
const MULTISINE: i32 = 9;

/// The number of a capture signal that selects none.
const NO_SIGNAL: u8 = 255;

impl Drive<'_> {
    /// The present value of a command.
    pub(super) fn command_value(&self, command: DriveCommand) -> u64 {
        use super::measured::signed;
        let commands = self.messages.commands.unverified().newest();
        match command {
            DriveCommand::CommandSource => self.selected_source() as u64,
            DriveCommand::ExcitationControl => self.measured(Measured::ExcitationStatus),
            DriveCommand::CaptureControl => u64::from(matches!(self.capture.phase() as u8, 1 | 2)),
            // The program is running.
            DriveCommand::ProgramControl => 1,
            DriveCommand::DownloadOffset => u64::from(self.download_offset()),
            // Write only.
            DriveCommand::ServicePassword => 0,
            DriveCommand::Controlword => u64::from(commands.control),
            DriveCommand::Mode => signed(i32::from(commands.mode as i8)),
            DriveCommand::TargetPosition => signed(commands.target_position_mdeg),
            DriveCommand::TargetVelocity => signed(commands.target_velocity_mdeg_s),
            DriveCommand::VelocityOffset => signed(commands.velocity_offset_mdeg_s),
        }
    }

    /// Executes a command.
    pub(super) fn execute(&mut self, command: DriveCommand, value: u64) -> Result<(), Abort> {
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
            DriveCommand::Controlword
            | DriveCommand::Mode
            | DriveCommand::TargetPosition
            | DriveCommand::TargetVelocity
            | DriveCommand::VelocityOffset => return self.command(command, value),
        }
        Ok(())
    }

    /// Changes the command to the loop. While too many are queued, an SDO waits and an RPDO is
    /// refused.
    fn command(&mut self, object: DriveCommand, value: u64) -> Result<(), Abort> {
        let before = self.messages.commands.unverified().number();
        let mut command = *self.messages.commands.unverified().newest();
        match object {
            DriveCommand::Controlword => command.control = value as u16,
            DriveCommand::Mode => {
                command.mode = Mode::from_code(value as i8).ok_or(Abort::Value)?
            }
            DriveCommand::TargetPosition => command.set_position(value as i32),
            DriveCommand::TargetVelocity => command.set_velocity(value as i32),
            _ => command.set_velocity_offset(value as i32),
        }
        let (taken, joins) = (self.outputs.taken.command, self.has_queued);
        let commands = &mut self.messages.commands;
        let mut is_accepted = true;
        commands.update(|it| is_accepted = it.set(&command, joins, taken));
        self.has_queued |= commands.unverified().number() != before;
        is_accepted.then_some(()).ok_or(Abort::NoResource)
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

    fn start_excitation(&mut self) -> Result<(), Abort> {
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
        let from = thousandths(self.outputs.telemetry.command);
        let profile = &self.values.profile;
        from.saturating_sub(reach) >= profile.min_position_mdeg
            && from.saturating_add(reach) <= profile.max_position_mdeg
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

/// Whether this number selects a capture signal, or none.
pub(super) fn is_signal(number: u32) -> bool {
    let is_known = |number| number == NO_SIGNAL || Signal::of_number(number).is_some();
    u8::try_from(number).is_ok_and(is_known)
}
