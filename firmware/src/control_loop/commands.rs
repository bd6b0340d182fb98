//! Commands to the control loop: the mailbox in which a front end posts them.
//!
//! Edges must not be lost and must not act twice, and what was written behind one acts behind it,
//! whatever the spacing of the writes. Changes of control bits and mode are therefore queued, each
//! with the targets that belong to it, and the loop takes one of them in each control period.
//! Requests and writes of targets are numbered: a number that differs from the one taken last is
//! new. A message that is read twice has the same effect as one that is read once.

use core::hash::{Hash, Hasher};

use super::Targets;
use crate::{
    check_value::check_value,
    command::excitation::{Run, Sample},
    interface::CommandSource,
};
use canopen::cia402::{self, Mode};

/// Queued commands.
const QUEUE: usize = 16;

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
    /// Added to the target of the cyclic velocity mode, and to the rate by which the position loop
    /// follows that of the cyclic position mode; mdeg/s.
    pub velocity_offset_mdeg_s: i32,
    /// Target of the torque modes; in the other cyclic modes added to the torque of the rate loop.
    /// Thousandths of the rated torque.
    pub target_torque_permille: i16,
    /// Number of writes of the target position; wraps.
    pub position_writes: u8,
    /// Number of writes of the target velocity or its offset; wraps.
    pub velocity_writes: u8,
    /// Number of writes of the target torque or its offset; wraps.
    pub torque_writes: u8,
}

impl Command {
    /// Cyclic synchronous position, without power.
    pub const DEFAULT: Self = Self {
        control: 0,
        mode: Mode::CyclicPosition,
        target_position_mdeg: 0,
        target_velocity_mdeg_s: 0,
        velocity_offset_mdeg_s: 0,
        target_torque_permille: 0,
        position_writes: 0,
        velocity_writes: 0,
        torque_writes: 0,
    };

    /// Sets a target position, mdeg.
    pub fn set_position(&mut self, mdeg: i32) {
        self.target_position_mdeg = mdeg;
        self.position_writes = self.position_writes.wrapping_add(1);
    }

    /// Sets a target velocity, mdeg/s.
    pub fn set_velocity(&mut self, mdeg_s: i32) {
        self.target_velocity_mdeg_s = mdeg_s;
        self.velocity_writes = self.velocity_writes.wrapping_add(1);
    }

    /// Sets a target torque, thousandths of the rated torque.
    pub fn set_torque(&mut self, permille: i16) {
        self.target_torque_permille = permille;
        self.torque_writes = self.torque_writes.wrapping_add(1);
    }

    /// Sets the offset of the target velocity, mdeg/s.
    pub fn set_velocity_offset(&mut self, mdeg_s: i32) {
        self.velocity_offset_mdeg_s = mdeg_s;
        self.velocity_writes = self.velocity_writes.wrapping_add(1);
    }
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
/// use firmware::control_loop::{Command, Commands};
///
/// let mut commands = Commands::new();
/// for control in [6, 7] {
///     let command = Command { control, ..*commands.newest() };
///     assert!(commands.set(&command, false, 0));
/// }
/// // Both are still to be taken.
/// assert_eq!([1, 2].map(|number| commands.at(number).control), [6, 7]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Commands {
    queue: [Command; QUEUE],
    /// The check value of each command: the loop verifies those that it takes.
    checks: [u32; QUEUE],
    /// Number of the newest command of the queue.
    newest: u32,
    /// Number of the command with which the loop starts.
    first: u32,
    /// The selected source of commands.
    pub source: Numbered<CommandSource>,
    /// Whether the network reports the loss of the master.
    pub network_loss: Numbered<bool>,
    /// Restarts of the loop with the parameters in the mailbox.
    pub restarts: u8,
    /// The sample of the running excitation that is due next, computed in advance, with the number
    /// of the request of that excitation.
    pub sample: (u8, Sample),
    /// What a front end makes the targets of the commands from. The loop does not use it; here the
    /// check value covers it.
    pub targets: Targets,
}

/// All but the queue.
impl Hash for Commands {
    fn hash<H: Hasher>(&self, state: &mut H) {
        let Self {
            queue: _,
            checks: _,
            newest,
            first,
            source,
            network_loss,
            restarts,
            sample,
            targets,
        } = self;
        (newest, first, source, network_loss, restarts, sample).hash(state);
        targets.hash(state);
    }
}

impl Default for Commands {
    fn default() -> Self {
        Self::new()
    }
}

impl Commands {
    /// No command.
    pub fn new() -> Self {
        Self {
            queue: [Command::DEFAULT; QUEUE],
            checks: [check_value(&Command::DEFAULT); QUEUE],
            newest: 0,
            first: 0,
            source: Numbered::new(CommandSource::Bus),
            network_loss: Numbered::new(false),
            restarts: 0,
            sample: (0, Sample::DEFAULT),
            targets: Targets::default(),
        }
    }

    /// Number of the newest command.
    pub fn number(&self) -> u32 {
        self.newest
    }

    /// Number of the command with which the loop starts.
    pub fn first(&self) -> u32 {
        self.first
    }

    /// The command of a number, one of the last sixteen.
    pub fn at(&self, number: u32) -> &Command {
        let [first, ..] = &self.queue;
        self.queue.get(number as usize % QUEUE).unwrap_or(first)
    }

    /// Whether the command of a number has its check value.
    pub fn is_intact(&self, number: u32) -> bool {
        let check = self.checks.get(number as usize % QUEUE);
        check.is_some_and(|check| *check == check_value(self.at(number)))
    }

    /// The sum of the check values of all queued commands.
    pub fn check_of_queue(&self) -> u32 {
        self.checks
            .iter()
            .fold(0, |sum, check| sum.rotate_left(5) ^ check)
    }

    /// Writes the command of a number. Where the one from which it was made differs from its check
    /// value, so does this one.
    fn put(&mut self, number: u32, command: &Command, is_intact: bool) {
        let slot = number as usize % QUEUE;
        if let (Some(queued), Some(check)) = (self.queue.get_mut(slot), self.checks.get_mut(slot)) {
            *queued = *command;
            *check = check_value(command) ^ u32::from(!is_intact);
        }
    }

    /// The newest command.
    pub fn newest(&self) -> &Command {
        self.at(self.newest)
    }

    /// Replaces the command; the loop has taken that of the number `taken`. A change of the control
    /// bits is queued; so is one of the mode, and one behind an edge that was not taken yet, unless
    /// it `joins`: it stands in the same frame as that edge. In a full queue a quick stop and
    /// disable voltage replace what was not taken yet. Returns false, without effect, if the queue
    /// is full.
    #[must_use]
    pub fn set(&mut self, command: &Command, joins: bool, taken: u32) -> bool {
        let is_full = self.newest.wrapping_sub(taken) >= QUEUE as u32 - 1;
        let is_intact = self.is_intact(self.newest);
        if is_full && ends_motion(command.control) {
            // The loop takes one in each control period, or reads again the one that it has.
            for number in 0..self.newest.wrapping_sub(taken).min(QUEUE as u32) {
                self.put(self.newest.wrapping_sub(number), command, is_intact);
            }
            return true;
        }
        let before = self.newest();
        let is_edge =
            |from: &Command, to: &Command| (from.control, from.mode) != (to.control, to.mode);
        let waits = self.newest != taken && is_edge(self.at(self.newest.wrapping_sub(1)), before);
        let is_apart = command != before && (waits || command.mode != before.mode);
        if command.control != before.control || (is_apart && !joins) {
            if is_full {
                return false;
            }
            self.newest = self.newest.wrapping_add(1);
        }
        self.put(self.newest, command, is_intact);
        true
    }

    /// Selects a source of commands.
    pub fn select(&mut self, source: CommandSource) {
        self.source.set(source);
    }

    /// Reports whether the network has lost the master.
    pub fn report_network(&mut self, is_lost: bool) {
        self.network_loss.set(is_lost);
    }

    /// Restarts the loop, with the commands of [`Commands::new`].
    pub fn restart(&mut self) {
        *self = Self {
            newest: self.newest,
            first: self.newest,
            restarts: self.restarts.wrapping_add(1),
            ..Self::new()
        };
    }
}

/// Whether a controlword stops the shaft or removes the power, whatever was requested before.
pub(crate) fn ends_motion(control: u16) -> bool {
    matches!(
        cia402::Command::from_controlword(control),
        cia402::Command::QuickStop | cia402::Command::DisableVoltage
    )
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

    fn change(
        commands: &mut Commands,
        taken: u32,
        joins: bool,
        change: impl FnOnce(&mut Command),
    ) -> bool {
        let mut command = *commands.newest();
        change(&mut command);
        commands.set(&command, joins, taken)
    }

    fn control(commands: &mut Commands, taken: u32, control: u16) -> bool {
        change(commands, taken, false, |command| command.control = control)
    }

    /// Controlwords that differ, and neither stop nor remove the power.
    fn word(number: u32) -> u16 {
        0x06 | (number as u16) << 8
    }

    #[test]
    fn a_command_that_was_made_from_a_corrupt_one_is_corrupt() {
        for slot in [0, 1] {
            let mut commands = Commands::new();
            assert!(control(&mut commands, 0, word(1)));
            commands.queue[slot].target_position_mdeg ^= 1 << 20;
            assert!(!commands.is_intact(slot as u32));
            for taken in [0, 1] {
                assert!(control(&mut commands, taken, word(2 + taken)));
                let is_from_corrupt = slot == 1;
                assert_eq!(commands.is_intact(commands.number()), !is_from_corrupt);
            }
        }
    }

    #[test]
    fn a_stop_replaces_what_was_not_taken_yet_of_a_full_queue() {
        for off in [0x00, 0x02, 0x0B] {
            let mut commands = Commands::new();
            let mut last = 0;
            while control(&mut commands, last.min(3), word(last + 1)) {
                last += 1;
            }
            assert!(control(&mut commands, 3, off));
            assert!((4..=commands.number()).all(|number| commands.at(number).control == off));
            assert_eq!(commands.at(3).control, word(3));
        }
    }

    #[test]
    fn no_change_of_the_control_bits_is_lost_until_the_queue_is_full() {
        let mut commands = Commands::new();
        let mut accepted = 0;
        while control(&mut commands, 0, word(accepted + 1)) {
            accepted += 1;
        }
        assert_eq!(accepted, QUEUE as u32 - 1);
        for number in 1..=accepted {
            assert_eq!(commands.at(number).control, word(number));
        }
        // Neither a mode nor a target joins the last edge of a full queue.
        assert!(!change(&mut commands, 0, false, |command| command.mode = Mode::None));
        assert!(!change(&mut commands, 0, false, |command| command.set_position(1)));
        // Once the loop has taken one there is room for one.
        assert!(control(&mut commands, 1, word(100)));
        assert!(!control(&mut commands, 1, word(101)));
    }

    #[test]
    fn a_target_acts_behind_the_edge_behind_which_it_was_written() {
        let mut commands = Commands::new();
        let position = |mdeg| move |command: &mut Command| command.set_position(mdeg);
        assert!(change(&mut commands, 0, false, position(1_000)));
        assert!(control(&mut commands, 0, 0x1f));
        // In the frame of the edge, in a frame behind it, and in one behind that.
        assert!(change(&mut commands, 0, true, position(2_000)));
        assert!(change(&mut commands, 0, false, position(3_000)));
        assert!(change(&mut commands, 0, false, position(4_000)));
        let targets = [0, 1, 2].map(|number| {
            let command = commands.at(number);
            (command.target_position_mdeg, command.position_writes)
        });
        assert_eq!(targets, [(1_000, 1), (2_000, 2), (4_000, 4)]);
        // The edge was taken.
        assert!(change(&mut commands, 2, false, position(5_000)));
        assert_eq!(commands.number(), 2);
    }

    #[test]
    fn a_mode_acts_before_the_control_bits_that_follow_it() {
        let mut commands = Commands::new();
        assert!(change(&mut commands, 0, false, |command| command.mode =
            Mode::ProfilePosition));
        assert!(control(&mut commands, 0, 0x1f));
        let [first, second] = [1, 2].map(|number| *commands.at(number));
        assert_eq!((first.mode, first.control), (Mode::ProfilePosition, 0));
        assert_eq!((second.mode, second.control), (Mode::ProfilePosition, 0x1f));
    }

    #[test]
    fn the_same_control_bits_are_no_new_command() {
        let mut commands = Commands::new();
        for _ in 0..100 {
            assert!(control(&mut commands, 0, 15));
        }
        assert_eq!(commands.number(), 1);
    }
}
