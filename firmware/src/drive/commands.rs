//! Values that code of the drive reads and writes: commands and orders.

use canopen::Abort;

use super::{Drive, objects::abort};
use crate::{
    application::{CommandSource, Request},
    capture::{CaptureSettings, Signal, Trigger},
    dictionary::{DriveCommand, Measured},
    parameters::{ExcitationSettings, Parameter},
    timing::thousandths,
};

/// Shape of the excitation that is a sum.
const MULTISINE: i32 = 9;

/// The number of a capture signal that selects none.
const NO_SIGNAL: u8 = 255;

/// What a master commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Commands {
    pub(super) controlword: u16,
    pub(super) mode: i8,
    pub(super) target_position_mdeg: i32,
    pub(super) target_velocity_mdeg_s: i32,
    pub(super) velocity_offset_mdeg_s: i32,
    /// The target position was written since the last control period.
    pub(super) is_new_position: bool,
    /// The target velocity or its offset was written since the last control period.
    pub(super) is_new_velocity: bool,
}

impl Commands {
    /// Cyclic synchronous position, without power.
    pub const DEFAULT: Self = Self {
        controlword: 0,
        mode: 8,
        target_position_mdeg: 0,
        target_velocity_mdeg_s: 0,
        velocity_offset_mdeg_s: 0,
        is_new_position: false,
        is_new_velocity: false,
    };
}

impl Drive<'_> {
    /// The present value of a command.
    pub(super) fn command_value(&self, command: DriveCommand) -> u64 {
        use super::measured::signed;
        let commands = &self.commands;
        match command {
            DriveCommand::CommandSource => self.application().selected_source() as u64,
            DriveCommand::ExcitationControl => self.measured(Measured::ExcitationStatus),
            DriveCommand::CaptureControl => u64::from(matches!(self.capture.phase() as u8, 1 | 2)),
            // The program is running.
            DriveCommand::ProgramControl => 1,
            DriveCommand::DownloadOffset => u64::from(self.download_offset()),
            // Write only.
            DriveCommand::ServicePassword => 0,
            DriveCommand::Controlword => u64::from(commands.controlword),
            DriveCommand::Mode => signed(i32::from(commands.mode)),
            DriveCommand::TargetPosition => signed(commands.target_position_mdeg),
            DriveCommand::TargetVelocity => signed(commands.target_velocity_mdeg_s),
            DriveCommand::VelocityOffset => signed(commands.velocity_offset_mdeg_s),
        }
    }

    /// Executes a command.
    pub(super) fn execute(&mut self, command: DriveCommand, value: u64) -> Result<(), Abort> {
        let commands = &mut self.commands;
        match command {
            DriveCommand::CommandSource => return self.switch_source(value),
            DriveCommand::ExcitationControl if value == 0 => {
                let stopped = self.control.application.request(Request::StopExcitation);
                return stopped.map_err(abort);
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
            DriveCommand::Controlword => commands.controlword = value as u16,
            DriveCommand::Mode => {
                let mode = value as i8;
                if canopen::cia402::Mode::from_code(mode).is_none() {
                    return Err(Abort::Value);
                }
                commands.mode = mode;
            }
            DriveCommand::TargetPosition => {
                commands.target_position_mdeg = value as i32;
                commands.is_new_position = true;
                self.failsafe.commanded();
            }
            DriveCommand::TargetVelocity => {
                commands.target_velocity_mdeg_s = value as i32;
                commands.is_new_velocity = true;
                self.failsafe.commanded();
            }
            DriveCommand::VelocityOffset => {
                commands.velocity_offset_mdeg_s = value as i32;
                commands.is_new_velocity = true;
                self.failsafe.commanded();
            }
        }
        Ok(())
    }

    /// Switches the source of the commands. At standstill it is the source after a reset too, once
    /// it is stored.
    fn switch_source(&mut self, value: u64) -> Result<(), Abort> {
        let source = if value == 1 {
            CommandSource::ServoPulse
        } else {
            CommandSource::Bus
        };
        let request = Request::Source(source);
        self.control.application.request(request).map_err(abort)?;
        // Refused while the loop is closed: only gains change then.
        let _ = self.set_parameter(Parameter::CommandSource, value as u32);
        Ok(())
    }

    fn start_excitation(&mut self) -> Result<(), Abort> {
        let settings = self.values.excitation;
        let run = settings.run().ok_or(Abort::Incompatible)?;
        if !self.has_room(&settings) {
            return Err(Abort::Incompatible);
        }
        self.control
            .application
            .start_excitation(run)
            .map_err(abort)
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
        let from = thousandths(self.application().telemetry().command);
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
