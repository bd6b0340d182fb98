//! The board's application in closed loop with a plant (reference semantics S9).
//!
//! At each PWM edge the timer takes the compare value that it was given; at every fourth edge the
//! application then samples the encoder and decides on the next one, which acts a period later.

use firmware::application::{Application, Bridge, Outputs, Request, Samples};
use model_core::{
    control::{
        cascade::Coefficients,
        compare::Compare,
        units::{Angle, float},
    },
    plant::Plant,
    sensors::encoder::Encoder,
    time::{CONTROL_PERIOD_TICKS, PWM_PERIOD_TICKS},
};

model_core::parameters! {
    /// The timer that switches the bridge.
    pub struct TimerParameters {
        /// 1 where the bridge is on for whole counts of the timer, 1/560 %; 0 where it is on for
        /// just as long as the control step decided.
        timer_counts [""]: 0.0, "1", 0.0, 1.0, "0: the loop is that of the equations; the board's timer counts";
    }
}

impl TimerParameters {
    /// The duty that the timer makes, %. A bridge that is off brakes here.
    fn duty_pct(&self, outputs: &Outputs) -> f64 {
        match outputs.bridge {
            Bridge::Driven(compare) if self.timer_counts >= 0.5 => compare.duty_pct(),
            Bridge::Driven(_) => float(outputs.duty),
            Bridge::Off => 0.0,
        }
    }
}

/// A board that was switched on and enabled at rest, just before tick 0.
#[derive(Debug, Clone)]
pub struct ClosedLoop<P> {
    application: Application,
    timer: TimerParameters,
    encoder: Encoder,
    /// The motor and what it moves.
    pub plant: P,
    /// What the application said last.
    pub outputs: Outputs,
    duty_pct: f64,
    /// The duty that is in force from the next edge on, %.
    pending_duty_pct: f64,
    tick: u64,
}

impl<P: Plant> ClosedLoop<P> {
    /// Closes the loop around a plant.
    pub fn new(
        coefficients: Coefficients,
        timer: TimerParameters,
        mut encoder: Encoder,
        plant: P,
    ) -> Self {
        let mut application = Application::new(coefficients);
        let word = encoder.word(plant.at(0).angle_deg);
        let outputs = application.step(&Samples {
            encoder: word,
            command: Angle::ZERO,
        });
        application.request(Request::Enable);
        Self {
            application,
            timer,
            encoder,
            plant,
            outputs,
            duty_pct: 0.0,
            pending_duty_pct: 0.0,
            tick: 0,
        }
    }

    /// The PWM edge at which the next period of 20 ticks starts, and what belongs to that instant;
    /// `command` gives the command that has arrived at a tick.
    #[inline(always)]
    pub fn start_period(&mut self, command: impl FnOnce(u64) -> Angle) {
        self.duty_pct = self.pending_duty_pct;
        self.plant.start_period(self.duty_pct);
        if self.tick.is_multiple_of(CONTROL_PERIOD_TICKS) {
            let encoder = self.encoder.word(self.plant.at(0).angle_deg);
            let command = command(self.tick);
            self.outputs = self.application.step(&Samples { encoder, command });
            self.pending_duty_pct = self.timer.duty_pct(&self.outputs);
        }
        self.tick += PWM_PERIOD_TICKS;
    }

    /// What the timer was given last: in force from the next edge on.
    pub fn compare(&self) -> Compare {
        match self.outputs.bridge {
            Bridge::Driven(compare) => compare,
            Bridge::Off => Compare::default(),
        }
    }

    /// The duty of the running period, %.
    pub fn duty_pct(&self) -> f64 {
        self.duty_pct
    }
}
