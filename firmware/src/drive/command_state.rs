//! What received frames command, for the comparison of two ways to process them.

use canopen::cia402::Parameters;

use super::{Device, RPDOS, commands::Commands, failsafe::Failsafe};

/// What the axis follows in the next control step, and what it follows after the next SYNC. The
/// same process data, received twice from the same state, make the same one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CommandState {
    commands: Commands,
    failsafe: Failsafe,
    parameters: Parameters,
    buffered: [Option<[u8; 8]>; RPDOS],
}

impl Device<'_> {
    /// The commands after the last received frame.
    pub fn command_state(&self) -> CommandState {
        CommandState {
            commands: *self.drive.commands,
            failsafe: self.drive.failsafe,
            parameters: self.drive.control.axis_parameters,
            buffered: self.node().buffered_process_data(),
        }
    }
}
