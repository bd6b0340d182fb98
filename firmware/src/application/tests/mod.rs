//! The application around a simulated motor.

extern crate std;

mod faults;
mod rates;
mod sources;
mod states;

use model_core::{
    control::{
        encoder_word::{EncoderCount, EncoderWord, Magnet},
        units::{Angle, rate},
    },
    plant::{
        Plant, Pwm,
        first_order::{FirstOrder, FirstOrderParameters},
    },
    sensors::{encoder::Encoder, noise::Noise},
};

use super::*;

/// A motor that turns as far as it likes.
fn without_stop() -> FirstOrderParameters {
    FirstOrderParameters {
        position_limit_deg: 32_000.0,
        ..FirstOrderParameters::DEFAULT
    }
}

/// A motor with its encoder.
pub(crate) struct Motor {
    plant: FirstOrder,
    encoder: Encoder,
    duty_pct: f64,
}

impl Motor {
    pub fn new() -> Self {
        Self {
            plant: FirstOrder::try_new(without_stop(), Pwm::Average).unwrap(),
            encoder: Encoder::new(Default::default(), Noise::new(0, 0)),
            duty_pct: 0.0,
        }
    }

    /// What an undisturbed board samples.
    pub fn samples(&mut self) -> Samples {
        Samples::at_rest(self.encoder.word(self.plant.at(20).angle_deg))
    }

    /// A PWM period more, as before.
    pub fn drift(&mut self) {
        self.plant.start_period(self.duty_pct);
    }

    /// A control period with what the board has decided.
    pub fn turn(&mut self, outputs: &Outputs) {
        for period in 0..4 {
            self.drift();
            if period == 0 {
                self.duty_pct = match outputs.bridge {
                    Bridge::Driven(_) => outputs.telemetry.duty.to_f64(),
                    Bridge::Coast | Bridge::Brake => 0.0,
                };
            }
        }
    }
}

/// A board, the motor that it drives, and a hand in the wiring.
pub(super) struct TestBoard {
    pub application: Application,
    motor: Motor,
    pub outputs: Outputs,
    /// What is commanded in each control period, if anything.
    pub command: Option<Angle>,
}

impl TestBoard {
    pub fn new(parameters: BoardParameters) -> Self {
        let mut board = Self {
            application: Application::new(parameters),
            motor: Motor::new(),
            outputs: Outputs {
                bridge: Bridge::Coast,
                state: BoardState::Initialising,
                fault: None,
                telemetry: Telemetry::default(),
            },
            command: None,
        };
        board.step();
        board
    }

    /// A board whose loop is closed.
    pub fn enabled() -> Self {
        let mut board = Self::new(BoardParameters::DEFAULT);
        board.request(Request::Enable);
        board.command = Some(Angle::ZERO);
        board.step();
        assert_eq!(board.outputs.state, BoardState::Enabled);
        board
    }

    /// A board at full rate.
    pub fn turning() -> Self {
        let mut board = Self::enabled();
        board.command = Some(Angle::from_int(30_000));
        board.steps(300);
        // 283.6 deg/s, and a count is 22 deg/s.
        assert!(board.outputs.telemetry.rate > rate(270.0));
        board
    }

    pub fn request(&mut self, request: Request) {
        assert_eq!(self.application.request(request), Ok(()), "{request:?}");
    }

    /// One control period with an undisturbed board.
    pub fn step(&mut self) -> Outputs {
        self.step_with(|_| {})
    }

    /// One control period; the hand changes what is sampled.
    pub fn step_with(&mut self, hand: impl FnOnce(&mut Samples)) -> Outputs {
        let mut samples = self.motor.samples();
        hand(&mut samples);
        if let Some(angle) = self.command {
            let _ = self.application.request(Request::Command(angle.into()));
        }
        self.outputs = self.application.step(&samples);
        self.motor.turn(&self.outputs);
        self.outputs
    }

    pub fn steps(&mut self, count: u32) -> Outputs {
        for _ in 0..count {
            self.step();
        }
        self.outputs
    }
}

/// A word of a healthy encoder.
pub(super) fn word(count: u16) -> EncoderWord {
    EncoderWord::of(EncoderCount::new(count), Magnet::Steady)
}
