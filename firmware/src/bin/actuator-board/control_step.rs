//! The control step with what surrounds it on the board.
//!
//! Its stages are functions that are not inlined, with names that a debugger or an emulator finds in
//! the ELF: [`gather`], [`application_step`].

use firmware::{
    application::{Application, Outputs, Request, Samples},
    frames::{Message, Order},
    parameters::BoardParameters,
};
use heapless::spsc::{Consumer, Producer};

use crate::{
    analog::Analog, bridge::Bridge, bus_state, encoder::Encoder, servo_pulse::ServoPulse,
    ticks::Ticks,
};

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
    application: Application,
    ticks: Ticks,
    messages: Consumer<'static, Message, 8>,
    save: Producer<'static, BoardParameters, 2>,
    was_late: bool,
}

impl ControlStep {
    /// An application that gets these messages and has its parameters saved there.
    pub fn new(
        application: Application,
        ticks: Ticks,
        messages: Consumer<'static, Message, 8>,
        save: Producer<'static, BoardParameters, 2>,
    ) -> Self {
        Self {
            application,
            ticks,
            messages,
            save,
            was_late: false,
        }
    }

    /// Serves what was asked for, then the control period itself.
    pub fn run(&mut self, samples: &mut Samples) -> Outputs {
        // A step that outlasts its PWM period is as good as missed: its duty came a period late.
        let missed = self.ticks.begin();
        samples.missed_periods = missed.saturating_add(u8::from(self.was_late));
        while let Some(Message::Command { order, angle }) = self.messages.dequeue() {
            self.obey(order);
            let _ = self.application.request(Request::Command(angle));
        }
        application_step(&mut self.application, samples)
    }

    /// The step's decision has been handed over.
    pub fn end(&mut self, is_late: bool) {
        self.was_late = is_late;
        self.ticks.end();
    }

    /// What is refused is refused: telemetry shows the state.
    fn obey(&mut self, order: Option<Order>) {
        let _ = match order {
            Some(Order::Application(request)) => self.application.request(request),
            Some(Order::RestoreDefaults) => self.application.retune(&BoardParameters::DEFAULT),
            Some(Order::SaveParameters) => {
                // One that finds the queue full asks for what is being saved anyway.
                let _ = self.save.enqueue(*self.application.parameters());
                Ok(())
            }
            None => Ok(()),
        };
    }
}
