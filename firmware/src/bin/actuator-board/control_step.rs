//! The control step with what surrounds it on the board.
//!
//! Its stages are functions that are not inlined, with names that a debugger or an emulator finds in
//! the ELF: [`gather`], [`serve`], [`application_step`], [`record`].

use firmware::{
    application::{Application, Outputs, Samples},
    capture::Capture,
    frames::{Access, Message},
    parameters::BoardParameters,
    service::Service,
    supervisor::{Part, Supervisor},
};
use heapless::spsc::{Consumer, Producer};

use crate::{
    analog::Analog, bridge::Bridge, bus_state, encoder::Encoder, heard, servo_pulse::ServoPulse,
    ticks::Ticks, watchdog::Watchdog,
};

/// What an access came to, and whether it was refused.
pub type Answer = (Access, bool);

/// What was measured since the last tick.
#[unsafe(no_mangle)]
#[inline(never)]
pub fn gather(
    encoder: &mut Encoder,
    analog: &mut Analog,
    pulse: &mut ServoPulse,
    bridge: &mut Bridge,
) -> Samples {
    Samples {
        encoder: encoder.finish(),
        current: analog.take_current(),
        scan: analog.take_scan(),
        servo_pulse_us: pulse.take_us(),
        bridge_tripped: bridge.take_trip(),
        missed_periods: 0,
        bus: bus_state::take(),
    }
}

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
    pub supervisor: Supervisor,
    pub watchdog: Watchdog,
    pub ticks: Ticks,
    pub queues: Queues,
    /// The last step ended behind the edge at which its duty was due.
    pub was_late: bool,
}

/// What the control step hands over, and what it gets.
pub struct Queues {
    pub messages: Consumer<'static, Message, 8>,
    pub answers: Producer<'static, Answer, 8>,
    pub save: Producer<'static, BoardParameters, 2>,
    pub outputs: Producer<'static, Outputs, 4>,
}

impl ControlStep {
    /// Serves what was asked for, then the control period itself.
    pub fn run(&mut self, samples: &mut Samples) -> Outputs {
        let missed = self.ticks.begin();
        samples.missed_periods = missed.saturating_add(u8::from(self.was_late));
        serve(self);
        let outputs = application_step(&mut self.application, samples);
        record(&mut self.capture, &outputs);
        outputs
    }

    /// The bridge has been told: hands over, and feeds the watchdog if every part is alive.
    pub fn end(&mut self, outputs: Outputs, is_late: bool) {
        // The background is behind: telemetry has a gap.
        let _ = self.queues.outputs.enqueue(outputs);
        self.was_late = is_late;
        heard::from(Part::Control);
        heard::tell(&mut self.supervisor);
        if self.supervisor.period() {
            self.watchdog.feed();
        }
        self.ticks.end();
    }
}

/// Messages that came in since the last tick.
#[unsafe(no_mangle)]
#[inline(never)]
fn serve(step: &mut ControlStep) {
    while let Some(message) = step.queues.messages.dequeue() {
        let served = step
            .service
            .serve(&mut step.application, &mut step.capture, &message);
        if let Some(answer) = served.answer {
            // As many as messages fit.
            let _ = step.queues.answers.enqueue(answer);
        }
        if served.save {
            // One that finds the queue full asks for what is being saved anyway.
            let _ = step.queues.save.enqueue(*step.application.parameters());
        }
    }
}

/// The capture's record of the control period.
#[unsafe(no_mangle)]
#[inline(never)]
fn record(capture: &mut Capture<'static>, outputs: &Outputs) {
    capture.sample(outputs);
}
