//! What front ends have in common whose protocol has no controlword: they close the loop by the
//! controlwords of CiA 402.

use canopen::cia402;

use super::Drive;
use crate::control_loop::Command;

/// Controlwords from which the loop is closed, one after the other.
const ENABLE: [u16; 3] = [0x06, 0x07, 0x0F];

impl Drive<'_> {
    /// Posts a change of the command, which is lost if too many are queued.
    pub(super) fn change_command(&mut self, change: impl FnOnce(&mut Command)) {
        let mut command = *self.messages.commands.unverified().newest();
        change(&mut command);
        self.replace_command(&command);
    }

    // Not inlined: the check value of the message is computed in one place.
    #[inline(never)]
    fn replace_command(&mut self, command: &Command) {
        let taken = self.outputs.taken.command;
        (self.messages.commands).update(|commands| _ = commands.set(command, false, taken));
    }

    /// Whether the last command has closed the loop, or has asked for it.
    pub(super) fn is_commanded(&self) -> bool {
        let newest = self.messages.commands.unverified().newest();
        cia402::Command::from_controlword(newest.control) == cia402::Command::EnableOperation
    }

    /// Follows a target in a mode, and closes the loop before if it is open.
    pub(super) fn follow(&mut self, mode: cia402::Mode, set: impl FnOnce(&mut Command)) {
        self.close_loop(mode);
        self.change_command(|command| {
            command.mode = mode;
            set(command);
        });
    }

    /// Closes the loop in a mode, if it is open.
    // Not inlined: each kind of target would have a copy.
    #[inline(never)]
    fn close_loop(&mut self, mode: cia402::Mode) {
        if !self.is_commanded() {
            for control in ENABLE {
                self.change_command(|command| (command.control, command.mode) = (control, mode));
            }
        }
    }
}
