//! The application around a simulated motor.

extern crate std;

mod conditions;
mod current_limit;
mod current_sense;
mod duty_limit;
mod faults;
mod missing_samples;
mod rate_observer;
mod rates;
mod sources;
mod stall;
mod states;
mod torque;
mod winding;

use core::ops::{Deref, DerefMut};

use model_core::{
    control::{
        cascade::Coefficients,
        encoder_correction::EncoderCorrection,
        encoder_word::{EncoderCount, EncoderWord, Magnet},
        parameters::ControlParameters,
        units::{Angle, rate},
    },
    plant::{
        Plant, Pwm,
        first_order::{FirstOrder, FirstOrderParameters},
    },
    sensors::{adc::AdcCode, dividers::leg_code, encoder::Encoder, noise::Noise},
};

use super::*;
use crate::{
    measure::{MotorConstants, Ripple},
    parameters::{LimitSettings, ModelSettings},
};

/// The default parameters with these of the control step.
fn with_gains(control: ControlParameters) -> BoardParameters {
    BoardParameters {
        control: Coefficients::try_new(&control).unwrap(),
        ..BoardParameters::DEFAULT
    }
}

/// A motor that turns as far as it likes.
fn without_stop() -> FirstOrderParameters {
    FirstOrderParameters {
        position_limit_deg: 32_000.0,
        ..FirstOrderParameters::DEFAULT
    }
}

/// A winding whose current is constant within a PWM period.
fn smooth() -> Ripple {
    Ripple::of(7.7, 1.0)
}

/// Back-EMF of the simulated motor, V per deg/s: 5.73 V at 283.6 deg/s.
const BACK_EMF_V_S_DEG: f64 = 5.73 / 283.6;

/// The code of a motor current.
fn current(current_ma: i32) -> AdcCode {
    AdcCode::from_pin_v(1.65 + 0.5 * f64::from(current_ma) / 1000.0)
}

/// The samples of the scanned channels.
fn scan(samples: &mut Samples) -> &mut Scan {
    samples.scan.as_mut().expect("scanned")
}

/// The legs of a motor that turns at this rate, deg/s.
pub(crate) fn turn(samples: &mut Samples, rate_deg_s: f64) {
    let back_emf_v = rate_deg_s * BACK_EMF_V_S_DEG;
    let scan = scan(samples);
    scan.leg_a = leg_code((5.998 + back_emf_v) / 2.0);
    scan.leg_b = leg_code((5.998 - back_emf_v) / 2.0);
}

/// Whether the motor is shorted, or driven against its back-EMF.
fn is_braked(outputs: &Outputs) -> bool {
    match outputs.bridge {
        Bridge::Coast => false,
        Bridge::Brake => true,
        Bridge::Driven(compare) => (compare.get() > 0) == (outputs.telemetry.back_emf_mv < 0),
    }
}

/// A motor with its encoder.
pub(crate) struct Motor {
    plant: FirstOrder,
    encoder: Encoder,
    duty_pct: f64,
    compare: PwmCompare,
}

impl Motor {
    pub fn new() -> Self {
        Self::of(without_stop())
    }

    /// A motor between hard stops at this angle and its opposite.
    pub fn between_stops(position_limit_deg: f64) -> Self {
        Self::of(FirstOrderParameters {
            position_limit_deg,
            ..FirstOrderParameters::DEFAULT
        })
    }

    fn of(parameters: FirstOrderParameters) -> Self {
        Self {
            plant: FirstOrder::try_new(parameters, Pwm::Average).unwrap(),
            encoder: Encoder::new(Default::default(), Noise::new(0, 0)),
            duty_pct: 0.0,
            compare: PwmCompare::default(),
        }
    }

    /// What an undisturbed board samples.
    pub fn samples(&mut self) -> Samples {
        let state = self.plant.at(20);
        let mut samples = Samples::at_rest(self.encoder.word(state.angle_deg));
        turn(&mut samples, state.rate_deg_s);
        let back_emf_v = state.rate_deg_s * BACK_EMF_V_S_DEG;
        let mean_a = (self.duty_pct / 100.0 * 5.998 - back_emf_v) / 7.7;
        // The sample in the on time, from the mean by the ripple of a sample of 0.
        let of_zero = Ripple::of(7.7, 1e-3).over_period(0, self.compare, 5998);
        let sampled_a = mean_a - f64::from(of_zero.mean_ma) / 1000.0;
        samples.current = Some(AdcCode::from_pin_v(1.65 + 0.5 * sampled_a));
        samples
    }

    /// The angle of the shaft, deg.
    pub fn angle_deg(&mut self) -> f64 {
        self.plant.at(20).angle_deg
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
                (self.duty_pct, self.compare) = match outputs.bridge {
                    Bridge::Driven(compare) => (outputs.telemetry.duty.to_f64(), compare),
                    Bridge::Coast | Bridge::Brake => (0.0, PwmCompare::default()),
                };
            }
        }
    }
}

/// An application with its settings.
pub(crate) struct Configured {
    application: Application,
    pub parameters: BoardParameters,
    pub motor: MotorConstants,
    pub limits: LimitSettings,
    pub observes_rate: bool,
}

impl Configured {
    /// After an ordinary reset.
    pub fn new(parameters: BoardParameters) -> Self {
        Self::after(parameters, Start::default())
    }

    /// After a reset of any kind, with the motor of the default model.
    pub fn after(parameters: BoardParameters, start: Start) -> Self {
        Self {
            application: Application::new(&parameters, start),
            parameters,
            motor: MotorConstants::of(&ModelSettings::DEFAULT),
            limits: LimitSettings::DEFAULT,
            observes_rate: false,
        }
    }

    pub fn control_period(&mut self, samples: &Samples) -> Outputs {
        let limits = MotorLimits::of(&self.limits, &self.parameters, &ModelSettings::DEFAULT);
        let settings = Settings {
            board: &self.parameters,
            motor: &self.motor,
            limits: &limits,
            dead_band: &DeadBandSettings::default(),
            encoder: &EncoderCorrection::NONE,
            observes_rate: self.observes_rate,
        };
        *self.application.control_period(settings, samples)
    }

    pub fn retune(&mut self, parameters: &BoardParameters) -> Result<(), Refused> {
        self.application.retune(&self.parameters, parameters)?;
        self.parameters = *parameters;
        Ok(())
    }
}

impl Deref for Configured {
    type Target = Application;

    fn deref(&self) -> &Application {
        &self.application
    }
}

impl DerefMut for Configured {
    fn deref_mut(&mut self) -> &mut Application {
        &mut self.application
    }
}

/// A board, the motor that it drives, and a hand in the wiring.
pub(super) struct TestBoard {
    pub application: Configured,
    motor: Motor,
    pub outputs: Outputs,
    /// What is commanded in each control period, if anything.
    pub command: Option<Angle>,
}

impl TestBoard {
    pub fn new(parameters: BoardParameters) -> Self {
        let mut board = Self {
            application: Configured::new(parameters),
            motor: Motor::new(),
            outputs: Outputs::default(),
            command: None,
        };
        board.step();
        board
    }

    /// A board whose loop is closed.
    pub fn enabled() -> Self {
        Self::enabled_with(BoardParameters::DEFAULT)
    }

    /// The same with these parameters.
    pub fn enabled_with(parameters: BoardParameters) -> Self {
        let mut board = Self::new(parameters);
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

    /// A board at a commanded rate, deg/s.
    pub fn turning_at(rate_deg_s: f64) -> Self {
        let mut board = Self::enabled();
        board.command = None;
        for _ in 0..250 {
            board.request(Request::Command(rate(rate_deg_s).into()));
            board.step();
        }
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
        self.outputs = self.application.control_period(&samples);
        self.motor.turn(&self.outputs);
        self.outputs
    }

    /// The rate of the shaft, deg/s.
    pub fn rate_deg_s(&mut self) -> f64 {
        self.motor.plant.at(20).rate_deg_s
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
