//! Commands to the control loop: the mailbox in which a front end posts them.
//!
//! Edges must not be lost and must not act twice, whatever the spacing of their writes. Changes of
//! the control bits are therefore queued, each with the targets that belong to it, and the loop
//! takes one of them in each control period. Requests and writes of targets are numbered: a number
//! that differs from the one taken last is new. A message that is read twice has the same effect as
//! one that is read once.

use crate::{
    command::excitation::{Run, Sample},
    interface::CommandSource,
};
use canopen::cia402::Mode;

/// Queued changes of the control bits.
const QUEUE: usize = 8;

/// What a front end commands in one control period.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Command {
    /// Control bits of the power drive system (IEC 61800-7-201): [`canopen::cia402::controlword`].
    pub control: u16,
    /// Mode of operation.
    pub mode: Mode,
    /// Target of the position modes, mdeg.
    pub target_position_mdeg: i32,
    /// Target of the velocity modes, mdeg/s.
    pub target_velocity_mdeg_s: i32,
    /// Added to the target of the cyclic velocity mode, mdeg/s.
    pub velocity_offset_mdeg_s: i32,
    /// Number of writes of the target position; wraps.
    pub position_writes: u8,
    /// Number of writes of the target velocity or its offset; wraps.
    pub velocity_writes: u8,
}

impl Command {
    /// Cyclic synchronous position, without power.
    pub const DEFAULT: Self = Self {
        control: 0,
        mode: Mode::CyclicPosition,
        target_position_mdeg: 0,
        target_velocity_mdeg_s: 0,
        velocity_offset_mdeg_s: 0,
        position_writes: 0,
        velocity_writes: 0,
    };
}

/// A request with its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Numbered<T> {
    /// The content of the last request.
    pub value: T,
    /// Number of requests; wraps.
    pub number: u8,
}

impl<T> Numbered<T> {
    const fn new(value: T) -> Self {
        Self { value, number: 0 }
    }

    fn set(&mut self, value: T) {
        self.value = value;
        self.number = self.number.wrapping_add(1);
    }
}

/// The mailbox of commands.
///
/// ```
/// use firmware::control_loop::Commands;
///
/// let mut commands = Commands::DEFAULT;
/// assert!(commands.set_control(6, 0));
/// assert!(commands.set_control(7, 0));
/// // Both are still to be taken.
/// assert_eq!([1, 2].map(|number| commands.at(number).control), [6, 7]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Commands {
    queue: [Command; QUEUE],
    /// Number of the newest command of the queue.
    newest: u32,
    /// The selected source of commands.
    pub source: Numbered<CommandSource>,
    /// Whether the network reports the loss of the master.
    pub network_loss: Numbered<bool>,
    /// Restarts of the loop with the parameters in the mailbox.
    pub restarts: u8,
    /// The sample of the running excitation that is due next, computed in advance, with the number
    /// of the request of that excitation.
    pub sample: (u8, Sample),
}

impl Commands {
    /// No command.
    pub const DEFAULT: Self = Self {
        queue: [Command::DEFAULT; QUEUE],
        newest: 0,
        source: Numbered::new(CommandSource::Bus),
        network_loss: Numbered::new(false),
        restarts: 0,
        sample: (0, Sample::DEFAULT),
    };

    /// Number of the newest command.
    pub fn number(&self) -> u32 {
        self.newest
    }

    /// The command of a number, one of the last eight.
    pub fn at(&self, number: u32) -> &Command {
        let [first, ..] = &self.queue;
        self.queue.get(number as usize % QUEUE).unwrap_or(first)
    }

    /// The newest command.
    pub fn newest(&self) -> &Command {
        self.at(self.newest)
    }

    fn newest_mut(&mut self) -> Option<&mut Command> {
        self.queue.get_mut(self.newest as usize % QUEUE)
    }

    /// Queues a change of the control bits; the loop has taken the command `taken`. Returns false,
    /// without effect, if the queue is full.
    #[must_use]
    pub fn set_control(&mut self, control: u16, taken: u32) -> bool {
        let command = *self.newest();
        if command.control == control {
            return true;
        }
        if self.newest.wrapping_sub(taken) >= QUEUE as u32 - 1 {
            return false;
        }
        self.newest = self.newest.wrapping_add(1);
        if let Some(newest) = self.newest_mut() {
            *newest = Command { control, ..command };
        }
        true
    }

    /// Changes mode and targets of the newest command.
    pub fn change(&mut self, change: impl FnOnce(&mut Command)) {
        if let Some(newest) = self.newest_mut() {
            change(newest);
        }
    }

    /// Sets a target position, mdeg.
    pub fn set_position(&mut self, mdeg: i32) {
        self.change(|command| {
            command.target_position_mdeg = mdeg;
            command.position_writes = command.position_writes.wrapping_add(1);
        });
    }

    /// Changes a target velocity or its offset.
    pub fn set_velocity(&mut self, change: impl FnOnce(&mut Command)) {
        self.change(|command| {
            change(command);
            command.velocity_writes = command.velocity_writes.wrapping_add(1);
        });
    }

    /// Selects a source of commands.
    pub fn select(&mut self, source: CommandSource) {
        self.source.set(source);
    }

    /// Reports whether the network has lost the master.
    pub fn report_network(&mut self, is_lost: bool) {
        self.network_loss.set(is_lost);
    }

    /// Restarts the loop, with the commands of [`Commands::DEFAULT`].
    pub fn restart(&mut self) {
        *self = Self {
            newest: self.newest,
            restarts: self.restarts.wrapping_add(1),
            ..Self::DEFAULT
        };
    }
}

/// The mailbox of excitations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ExcitationRequest {
    /// The excitation to be started; `None` ends the one that runs.
    pub run: Option<Run>,
    /// Number of requests; wraps.
    pub number: u8,
}

impl ExcitationRequest {
    /// No request.
    pub const NONE: Self = Self {
        run: None,
        number: 0,
    };

    /// Requests an excitation.
    pub fn start(&mut self, run: Run) {
        self.request(Some(run));
    }

    /// Requests the end of the excitation that runs.
    pub fn stop(&mut self) {
        self.request(None);
    }

    fn request(&mut self, run: Option<Run>) {
        *self = Self {
            run,
            number: self.number.wrapping_add(1),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_change_of_the_control_bits_is_lost_until_the_queue_is_full() {
        let mut commands = Commands::DEFAULT;
        let mut accepted = 0;
        while commands.set_control(accepted as u16 + 1, 0) {
            accepted += 1;
        }
        assert_eq!(accepted, QUEUE as u32 - 1);
        for number in 0..=accepted {
            assert_eq!(commands.at(number).control, number as u16);
        }
        // Once the loop has taken one there is room for one.
        assert!(commands.set_control(100, 1));
        assert!(!commands.set_control(101, 1));
    }

    #[test]
    fn a_target_belongs_to_the_control_bits_behind_which_it_was_written() {
        let mut commands = Commands::DEFAULT;
        commands.set_position(1_000);
        assert!(commands.set_control(0x1f, 0));
        assert!(commands.set_control(0x0f, 0));
        commands.set_position(2_000);
        let targets = [1, 2].map(|number| {
            let command = commands.at(number);
            (command.target_position_mdeg, command.position_writes)
        });
        assert_eq!(targets, [(1_000, 1), (2_000, 2)]);
    }

    #[test]
    fn the_same_control_bits_are_no_new_command() {
        let mut commands = Commands::DEFAULT;
        for _ in 0..100 {
            assert!(commands.set_control(15, 0));
        }
        assert_eq!(commands.number(), 1);
    }
}
