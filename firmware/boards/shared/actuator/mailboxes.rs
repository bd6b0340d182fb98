//! The mailboxes between loop and communication.
//!
//! A message is written in memory of its writer, and posted by an exchange of two references: the
//! communication locks the loop out for some instructions, whatever the size of the message.

use core::mem::swap;

use firmware::{
    application::Outputs,
    check_value::Checked,
    control_loop::{Commands, ExcitationRequest, LoopParameters},
    drive::Messages,
    interface::Taken,
};
use rtic::Mutex;

/// Memory for a message.
type Memory<T> = &'static mut Checked<T>;

/// The messages to the loop.
pub struct Mailboxes {
    commands: Memory<Commands>,
    parameters: Memory<LoopParameters>,
    excitation: Memory<ExcitationRequest>,
}

/// The messages for a control period.
pub type ForPeriod<'a> = (&'a Commands, &'a LoopParameters, &'a ExcitationRequest);

impl Mailboxes {
    /// Mailboxes in this memory, with its messages.
    pub fn new(memory: &'static mut Messages) -> Self {
        let Messages {
            commands,
            parameters,
            excitation,
        } = memory;
        Self {
            commands,
            parameters,
            excitation,
        }
    }

    /// The messages.
    pub fn read(&self) -> ForPeriod<'_> {
        let parameters = self.parameters.unverified();
        (
            self.commands.unverified(),
            parameters,
            self.excitation.unverified(),
        )
    }

    /// The messages for a control period of a loop that has taken others; `None` if one that it
    /// will take differs from its check value.
    pub fn verify(&self, taken: &Taken) -> Option<ForPeriod<'_>> {
        let commands = self.commands.get()?;
        let next = taken.command.wrapping_add(1);
        let is_next_intact = taken.command == commands.number() || commands.is_intact(next);
        if !is_next_intact || !commands.is_intact(taken.command) {
            return None;
        }
        let is_restart = commands.restarts != taken.restarts;
        if is_restart && !commands.is_intact(commands.first()) {
            return None;
        }
        if is_restart || self.parameters.unverified().number != taken.parameters {
            self.parameters.get()?;
        }
        if self.excitation.unverified().number != taken.excitation {
            self.excitation.get()?;
        }
        Some(self.read())
    }
}

/// The end of the communication: memory for the next messages.
pub struct Poster {
    spare: Mailboxes,
    /// Numbers of changes of the messages that were posted last.
    posted: [u32; 3],
}

impl Poster {
    /// A poster with this memory, whose messages are posted already.
    pub fn new(memory: &'static mut Messages) -> Self {
        let posted = changes(memory);
        Self {
            posted,
            spare: Mailboxes::new(memory),
        }
    }

    /// Posts the messages that have changed.
    pub fn post(&mut self, messages: &Messages, mailboxes: &mut impl Mutex<T = Mailboxes>) {
        let spare = &mut self.spare;
        let changes = changes(messages);
        let [commands, parameters, excitation] = self.posted;
        let [new_commands, new_parameters, new_excitation] = changes;
        if new_commands != commands {
            *spare.commands = messages.commands;
            mailboxes.lock(|posted| swap(&mut posted.commands, &mut spare.commands));
        }
        if new_parameters != parameters {
            *spare.parameters = messages.parameters;
            mailboxes.lock(|posted| swap(&mut posted.parameters, &mut spare.parameters));
        }
        if new_excitation != excitation {
            *spare.excitation = messages.excitation;
            mailboxes.lock(|posted| swap(&mut posted.excitation, &mut spare.excitation));
        }
        self.posted = changes;
    }
}

/// The numbers of changes of the messages.
fn changes(messages: &Messages) -> [u32; 3] {
    [
        messages.commands.changes(),
        messages.parameters.changes(),
        messages.excitation.changes(),
    ]
}

/// The last outputs of the loop.
pub struct Telemetry {
    outputs: Memory<Outputs>,
    is_new: bool,
}

impl Telemetry {
    /// A mailbox in this memory.
    pub fn new(outputs: Memory<Outputs>) -> Self {
        Self {
            outputs,
            is_new: false,
        }
    }

    /// Publishes the outputs of a control period.
    pub fn publish(&mut self, outputs: &Outputs) {
        self.outputs.replace(outputs);
        self.is_new = true;
    }
}

/// The end of the communication: memory for the outputs that it reads.
pub struct Reader(Memory<Outputs>);

impl Reader {
    /// A reader with this memory.
    pub fn new(memory: Memory<Outputs>) -> Self {
        Self(memory)
    }

    /// The outputs that were published since the last call, unless they differ from their check
    /// value.
    pub fn take(&mut self, mailbox: &mut impl Mutex<T = Telemetry>) -> Option<&Outputs> {
        let is_new = mailbox.lock(|mailbox| {
            if mailbox.is_new {
                swap(&mut mailbox.outputs, &mut self.0);
            }
            core::mem::take(&mut mailbox.is_new)
        });
        if is_new { self.0.get() } else { None }
    }
}
