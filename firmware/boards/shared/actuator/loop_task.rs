//! The control loop on the board: both copies of a control period, the shutdown after a difference,
//! and the watchdogs.

use drivers::bridge::Bridge as _;
use firmware::{
    application::{Outputs, Samples},
    control_loop::{Inputs, Loop},
    faults::Fault,
    replicated::{Replicated, Shutdown},
};

use super::{
    mailboxes::{ForPeriod, Mailboxes},
    program_check, shutdown,
    watchdog_supervisor::WatchdogSupervisor,
};
use crate::peripherals::ActuatorBridge;

/// The loop and what protects it.
pub struct LoopTask {
    copies: Replicated,
    /// After corrupt data or a corrupt program: the copies are used no more.
    shutdown: Shutdown,
    watchdog: WatchdogSupervisor,
    /// The outputs of its last control period.
    shutdown_outputs: Outputs,
    /// Whether the motor was driven before the last control step.
    was_driven: bool,
    /// Whether the duty of the last but one and of the last control step was set too late.
    was_late: bool,
    is_late: bool,
}

/// The control period of one copy, not inlined and with a fixed symbol, so that the emulator counts
/// its instructions and a debugger shows it.
#[unsafe(no_mangle)]
#[inline(never)]
fn first_copy(copies: &mut Replicated, inputs: &Inputs<'_>) {
    copies.step(inputs);
}

/// The same of the second copy, with the comparison.
#[unsafe(no_mangle)]
#[inline(never)]
fn second_copy(copies: &mut Replicated, inputs: &Inputs<'_>) -> bool {
    copies.repeat(inputs)
}

impl LoopTask {
    /// The task of a loop.
    pub fn new(control_loop: Loop, watchdog: WatchdogSupervisor) -> Self {
        Self {
            copies: Replicated::new(control_loop),
            shutdown: Shutdown::default(),
            watchdog,
            shutdown_outputs: Outputs::default(),
            was_driven: false,
            was_late: false,
            is_late: false,
        }
    }

    /// Begins the control period of this number; returns how many did not run before it.
    pub fn begin(&mut self, control_period: u32) -> u8 {
        self.watchdog.begin_step(control_period)
    }

    /// The control step: the first copy decides what the bridge does from the next update on.
    pub fn step(&mut self, samples: &Samples, mailboxes: &Mailboxes, bridge: &mut ActuatorBridge) {
        self.was_driven = bridge.is_on();
        self.was_late = self.is_late;
        if program_check::is_corrupt() {
            self.begin_shutdown(Fault::ProgramCorrupt);
        }
        if !self.shutdown.has_begun() {
            match mailboxes.verify(self.copies.first().taken()) {
                Some(messages) => {
                    let inputs = inputs(samples, messages, self.was_late);
                    first_copy(&mut self.copies, &inputs);
                }
                None => self.begin_shutdown(Fault::DataCorrupt),
            }
        }
        if self.shutdown.has_begun() {
            self.shut_down();
        }
        bridge.command(self.outputs().bridge);
        self.is_late = bridge.timer().is_late();
    }

    /// Computes the control period with the second copy, and compares; a difference begins the
    /// shutdown before the outputs of the first copy act. Feeds the watchdogs. Returns the outputs.
    pub fn repeat(
        &mut self,
        samples: &Samples,
        mailboxes: &Mailboxes,
        bridge: &mut ActuatorBridge,
    ) -> &Outputs {
        if !self.shutdown.has_begun() && !self.agrees(samples, mailboxes) {
            // A wrong result may have switched the bridge off.
            self.was_driven |= bridge.is_on();
            self.begin_shutdown(Fault::DataCorrupt);
            self.shut_down();
            bridge.command(self.outputs().bridge);
        }
        self.watchdog.end_step(self.is_late);
        self.outputs()
    }

    /// The outputs of the last control period.
    fn outputs(&self) -> &Outputs {
        if self.shutdown.has_begun() {
            &self.shutdown_outputs
        } else {
            self.copies.first().outputs()
        }
    }

    fn agrees(&mut self, samples: &Samples, mailboxes: &Mailboxes) -> bool {
        // A message that has changed since the first copy has read it makes a difference.
        let inputs = inputs(samples, mailboxes.read(), self.was_late);
        second_copy(&mut self.copies, &inputs)
    }

    /// The outputs of a control period of the shutdown, or the restart at its end.
    fn shut_down(&mut self) {
        let outputs = self.shutdown.step(&self.shutdown_outputs);
        self.shutdown_outputs = outputs.unwrap_or_else(|| shutdown::restart());
    }

    /// The motor brakes if it was driven, unless the parameters exclude it.
    #[inline(never)]
    fn begin_shutdown(&mut self, fault: Fault) {
        let brakes = self.was_driven && self.copies.braking_faults().contains(fault);
        self.shutdown_outputs = *self.outputs();
        self.shutdown.begin(fault, brakes);
    }
}

/// The inputs of a copy.
fn inputs<'a>(
    samples: &'a Samples,
    (commands, parameters, excitation): ForPeriod<'a>,
    was_late: bool,
) -> Inputs<'a> {
    Inputs {
        samples,
        was_late,
        commands,
        parameters,
        excitation,
    }
}
