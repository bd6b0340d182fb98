//! The control step with what surrounds it on the board.
//!
//! Its stages are functions that are not inlined, with names that a debugger or an emulator finds in
//! the ELF: `gather`, [`serve`], [`application_step`], [`record`].

use firmware::{
    application::{Application, Outputs, Samples},
    capture::Capture,
    command::excitation::{ExcitationSettings, Run, Sample},
    frames::{Access, Message, Order},
    parameters::BoardParameters,
    service::Service,
};
use heapless::spsc::{Consumer, Producer};

use crate::actuator::{
    slot::{Giver, Taker},
    vigil::Vigil,
};

/// What an access came to, and whether it was refused.
pub type Answer = (Access, bool);

/// One control period of the application.
#[unsafe(no_mangle)]
#[inline(never)]
fn application_step(application: &mut Application, samples: &Samples) -> Outputs {
    application.step(samples)
}

/// The application, and who talks to it.
pub struct ControlStep {
    pub application: Application,
    pub capture: Capture<'static>,
    pub service: Service,
    pub vigil: Vigil,
    pub queues: Queues,
    pub wanted: Wanted,
}

/// What was asked for and takes more than a tick.
#[derive(Default)]
pub struct Wanted {
    /// The parameters of now are to be saved, once the background takes them.
    save: bool,
    /// The number of the start whose excitation is on its way; none once it was called off.
    start: Option<u8>,
    /// The number of the last start; wraps.
    last_start: u8,
    /// The number of the start whose excitation runs, if one does.
    running: u8,
}

/// Commands that may wait for a tick, and one: a bus that brings one each 0.3 ms.
pub const COMMANDS: usize = 16;

/// Something with the number of the start that it belongs to.
pub type Numbered<T> = (u8, T);

/// What the control step hands over, and what it gets.
pub struct Queues {
    pub commands: Consumer<'static, Message, COMMANDS>,
    pub accesses: Consumer<'static, Message, 8>,
    pub answers: Producer<'static, Answer, 8>,
    pub save: Giver<BoardParameters>,
    pub outputs: Producer<'static, Outputs, 3>,
    pub excitations: Giver<Numbered<ExcitationSettings>>,
    pub runs: Taker<Numbered<Run>>,
    pub due: Giver<Numbered<u64>>,
    pub samples: Taker<Numbered<Sample>>,
}

impl ControlStep {
    /// Serves what was asked for, then the control period itself.
    pub fn run(&mut self, samples: &mut Samples, tick: u32) -> Outputs {
        samples.missed_periods = self.vigil.begin(tick);
        serve(self);
        let outputs = application_step(&mut self.application, samples);
        record(&mut self.capture, &outputs);
        if let Some(tick) = self.application.sample_due() {
            self.queues.due.put((self.wanted.running, tick));
        }
        outputs
    }

    /// What the background has made of an excitation.
    fn take_excitation(&mut self) {
        let (application, wanted) = (&mut self.application, &mut self.wanted);
        self.queues.samples.take_as(|(number, sample)| {
            if *number == wanted.running {
                application.take_sample(*sample);
            }
        });
        self.queues.runs.take_as(|(number, run)| {
            if wanted.start == Some(*number) {
                wanted.start = None;
                wanted.running = *number;
                // The loop may have been opened meanwhile: there is nothing to excite then.
                let _ = application.start_excitation(*run);
            }
        });
    }

    /// The bridge has been told: hands over, and feeds the watchdog if every part is alive.
    pub fn end(&mut self, outputs: Outputs, is_late: bool) {
        if is_late {
            self.application.was_late();
        }
        // The background is behind: telemetry has a gap.
        let _ = self.queues.outputs.enqueue(outputs);
        self.service.note_starved(self.vigil.end());
    }
}

/// What came in since the last tick: all orders, an angle alone if nothing came after it, one access.
#[unsafe(no_mangle)]
#[inline(never)]
fn serve(step: &mut ControlStep) {
    step.take_excitation();
    while let Some(message) = step.queues.commands.dequeue() {
        let is_angle_alone = matches!(message, Message::Command { order: None, .. });
        if !(is_angle_alone && step.queues.commands.ready()) {
            answer(step, &message);
        }
    }
    if let Some(message) = step.queues.accesses.dequeue() {
        answer(step, &message);
    }
    if step.wanted.save {
        let parameters = step.application.parameters();
        step.wanted.save = !step.queues.save.put_new(|| *parameters);
    }
}

#[inline(never)]
fn answer(step: &mut ControlStep, message: &Message) {
    let served = step
        .service
        .serve(&mut step.application, &mut step.capture, message);
    if let Some(answer) = served.answer {
        // As many as accesses fit.
        let _ = step.queues.answers.enqueue(answer);
    }
    step.wanted.save |= served.save;
    let calls_off = |order| matches!(order, Some(Order::Application(_)));
    if matches!(message, Message::Command { order, .. } if calls_off(*order)) {
        step.wanted.start = None;
    }
    if served.start {
        let number = step.wanted.last_start.wrapping_add(1);
        let settings = step.service.excitation();
        // One that finds another waiting comes in the very tick of that one.
        if step.queues.excitations.put_new(|| (number, *settings)) {
            step.wanted.last_start = number;
            step.wanted.start = Some(number);
        }
    }
}

/// The capture's record of the control period.
#[unsafe(no_mangle)]
#[inline(never)]
fn record(capture: &mut Capture<'static>, outputs: &Outputs) {
    capture.sample(outputs);
}
