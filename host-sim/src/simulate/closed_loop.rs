//! The board's application in closed loop with a plant (reference semantics S9).
//!
//! At each PWM edge the timer takes the compare value that it was given; at every fourth edge the
//! application then samples the encoder and decides on the next one, which acts a period later.

use firmware::application::{Application, Bridge, Outputs, Request, Samples};
use model_core::{
    control::{
        cascade::Coefficients,
        compare::Compare,
        encoder_word::{COUNT_DEG, EncoderCount, EncoderWord},
        units::Angle,
    },
    plant::Plant,
    time::{CONTROL_PERIOD_TICKS, PWM_PERIOD_TICKS},
};

/// What an encoder gives for a shaft.
pub trait Encoder<P> {
    /// The word at this instant.
    fn word(&mut self, plant: &P) -> EncoderWord;
}

/// An encoder without any error but its 12 bits.
#[derive(Debug, Clone, Copy, Default)]
pub struct IdealEncoder;

impl<P: Plant> Encoder<P> for IdealEncoder {
    #[inline]
    fn word(&mut self, plant: &P) -> EncoderWord {
        let counts = plant.at(0).angle_deg / COUNT_DEG + 0.5;
        // Rounded down; the cast alone rounds toward zero.
        let whole = counts as i64;
        let below = whole - i64::from(whole as f64 > counts);
        EncoderWord::healthy(EncoderCount::new(below as u16))
    }
}

/// A board that was switched on and enabled at rest, just before tick 0.
#[derive(Debug, Clone)]
pub struct ClosedLoop<P, E> {
    application: Application,
    /// The motor and what it moves.
    pub plant: P,
    encoder: E,
    /// What the application said last.
    pub outputs: Outputs,
    duty_pct: f64,
    tick: u64,
}

impl<P: Plant, E: Encoder<P>> ClosedLoop<P, E> {
    /// Closes the loop around a plant.
    pub fn new(coefficients: Coefficients, plant: P, mut encoder: E) -> Self {
        let mut application = Application::new(coefficients);
        let encoder_word = encoder.word(&plant);
        let outputs = application.step(&Samples {
            encoder: encoder_word,
            command: Angle::ZERO,
        });
        application.request(Request::Enable);
        Self {
            application,
            plant,
            encoder,
            outputs,
            duty_pct: 0.0,
            tick: 0,
        }
    }

    /// The PWM edge at which the next period of 20 ticks starts, and what belongs to that instant;
    /// `command` gives the command that has arrived at a tick.
    #[inline]
    pub fn start_period(&mut self, command: impl FnOnce(u64) -> Angle) {
        self.duty_pct = self.outputs.duty.to_num();
        self.plant.start_period(self.duty_pct);
        if self.tick.is_multiple_of(CONTROL_PERIOD_TICKS) {
            let encoder = self.encoder.word(&self.plant);
            self.outputs = self.application.step(&Samples {
                encoder,
                command: command(self.tick),
            });
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
