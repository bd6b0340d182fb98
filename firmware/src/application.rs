//! One control period of the board.
//!
//! | state | bridge | left by |
//! |---|---|---|
//! | [`Disabled`](State::Disabled) | off, the motor coasts | [`Request::Enable`], once the encoder was valid |
//! | [`Enabled`](State::Enabled) | driven by the control step | [`Request::Disable`], a fault |
//! | [`Fault`](State::Fault) | off, the motor coasts | [`Request::Acknowledge`] |
//!
//! The encoder may lose [`ENCODER_PATIENCE`] samples in a row; meanwhile the last duty stays and
//! the integrator rests. The next lost sample is [`Fault::EncoderLost`], and the bridge is off from
//! the next PWM edge on: 13 ms after the first lost sample, 17 ms after the last valid one.

use model_core::control::{
    cascade::{self, Coefficients},
    compare::Compare,
    encoder_word::EncoderWord,
    units::{Angle, Percent, Rate},
};

/// Encoder samples in a row that may be lost before the bridge is switched off.
pub const ENCODER_PATIENCE: u8 = 3;

/// What the board wants of the application.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Request {
    /// Close the loop.
    Enable,
    /// Open the loop.
    Disable,
    /// Take note of the fault and go to [`State::Disabled`].
    Acknowledge,
}

/// Why the bridge was switched off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Fault {
    /// The encoder gave no valid word for too long.
    EncoderLost = 1,
}

/// The operating state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// The loop is open.
    Disabled,
    /// The loop is closed.
    Enabled,
    /// The loop is open until somebody acknowledges.
    Fault(Fault),
}

/// What was sampled at the start of the period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Samples {
    /// The encoder's word.
    pub encoder: EncoderWord,
    /// The commanded angle.
    pub command: Angle,
}

/// What the bridge shall do from the next PWM edge on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bridge {
    /// All switches open.
    Off,
    /// Driven for this share of each PWM period, braked for the rest.
    Driven(Compare),
}

/// What a period decided, and what it knows of the actuator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outputs {
    /// For the bridge.
    pub bridge: Bridge,
    /// The operating state.
    pub state: State,
    /// The measured angle.
    pub angle: Angle,
    /// The estimated rate.
    pub rate: Rate,
    /// The commanded rate.
    pub rate_command: Rate,
    /// The duty before the timer rounds it.
    pub duty: Percent,
}

/// The application: coefficients, and everything that it remembers.
#[derive(Debug, Clone)]
pub struct Application {
    coefficients: Coefficients,
    control: cascade::State,
    state: State,
    lost_samples: u8,
    held: cascade::Step,
}

impl Application {
    /// A disabled application with these coefficients.
    ///
    /// ```
    /// use firmware::application::{Application, State};
    /// use model_core::control::{cascade::Coefficients, parameters::ControlParameters};
    ///
    /// let coefficients = Coefficients::try_new(&ControlParameters::DEFAULT).unwrap();
    /// assert_eq!(Application::new(coefficients).state(), State::Disabled);
    /// ```
    pub fn new(coefficients: Coefficients) -> Self {
        Self {
            coefficients,
            control: cascade::State::default(),
            state: State::Disabled,
            lost_samples: 0,
            held: cascade::Step::default(),
        }
    }

    /// The operating state.
    pub fn state(&self) -> State {
        self.state
    }

    /// Takes new coefficients; the duty does not jump.
    pub fn retune(&mut self, coefficients: Coefficients) {
        self.control.retune(&self.coefficients, &coefficients);
        self.coefficients = coefficients;
    }

    /// Asks for another operating state; what does not fit the present one is ignored.
    ///
    /// Closing the loop takes that the encoder is valid at this moment.
    pub fn request(&mut self, request: Request) {
        if let (State::Fault(Fault::EncoderLost), Request::Acknowledge) = (self.state, request) {
            // The shaft may have turned by any angle meanwhile.
            self.control.disorient();
        }
        self.state = match (self.state, request) {
            (State::Disabled, Request::Enable) if self.is_oriented() => State::Enabled,
            (State::Enabled, Request::Disable) => State::Disabled,
            (State::Fault(_), Request::Acknowledge) => State::Disabled,
            (state, _) => state,
        };
    }

    fn is_oriented(&self) -> bool {
        self.control.is_oriented() && self.lost_samples == 0
    }

    /// One control period.
    pub fn step(&mut self, samples: &Samples) -> Outputs {
        let valid = self
            .control
            .observe(&self.coefficients, samples.encoder)
            .is_ok();
        self.lost_samples = if valid {
            0
        } else {
            self.lost_samples.saturating_add(1)
        };
        if self.state == State::Enabled && self.lost_samples > ENCODER_PATIENCE {
            self.state = State::Fault(Fault::EncoderLost);
        }
        if self.state != State::Enabled {
            self.control.release();
            self.held = cascade::Step::default();
        } else if valid {
            self.held = self.control.regulate(&self.coefficients, samples.command);
        }
        self.outputs()
    }

    fn outputs(&self) -> Outputs {
        let driven = self.state == State::Enabled;
        Outputs {
            bridge: if driven {
                Bridge::Driven(self.held.compare)
            } else {
                Bridge::Off
            },
            state: self.state,
            angle: self.control.angle(),
            rate: self.control.rate(),
            rate_command: self.held.rate_command,
            duty: self.held.duty,
        }
    }
}

#[cfg(test)]
mod tests {
    use model_core::control::{
        encoder_word::{EncoderCount, Magnet},
        parameters::ControlParameters,
        units::angle,
    };

    use super::*;

    const LOST: EncoderWord = EncoderWord::new(0);

    fn samples(encoder: EncoderWord) -> Samples {
        Samples {
            encoder,
            command: angle(10.0),
        }
    }

    fn zero() -> EncoderWord {
        EncoderWord::of(EncoderCount::new(0), Magnet::Steady)
    }

    fn enabled() -> Application {
        let coefficients = Coefficients::try_new(&ControlParameters::DEFAULT).unwrap();
        let mut application = Application::new(coefficients);
        application.step(&samples(zero()));
        application.request(Request::Enable);
        assert_eq!(application.state(), State::Enabled);
        application
    }

    #[test]
    fn the_loop_is_not_closed_before_the_encoder_was_valid() {
        let coefficients = Coefficients::try_new(&ControlParameters::DEFAULT).unwrap();
        let mut application = Application::new(coefficients);
        application.step(&samples(LOST));
        application.request(Request::Enable);
        assert_eq!(application.state(), State::Disabled);
    }

    #[test]
    fn a_disabled_bridge_is_off_and_the_integrator_empty() {
        let mut application = enabled();
        for _ in 0..100 {
            application.step(&samples(zero()));
        }
        application.request(Request::Disable);
        assert_eq!(application.step(&samples(zero())).bridge, Bridge::Off);
        application.request(Request::Enable);
        // Small enough for no limit to hide what is left: 8/s 1 deg 1.318 %/(deg/s).
        let small = Samples {
            encoder: zero(),
            command: angle(1.0),
        };
        assert_eq!(application.step(&small), enabled().step(&small));
    }

    #[test]
    fn gains_changed_while_the_bridge_is_off_do_not_kick_it_when_it_is_enabled() {
        let stiffer = Coefficients::try_new(&ControlParameters {
            proportional_gain: 10.0,
            ..ControlParameters::DEFAULT
        })
        .unwrap();
        for requests in [[Request::Disable, Request::Enable], [Request::Enable; 2]] {
            let mut application = enabled();
            application.step(&samples(zero()));
            application.request(Request::Disable);
            application.step(&samples(zero()));
            application.request(requests[0]);
            application.retune(stiffer);
            application.request(requests[1]);
            let at_rest = Samples {
                encoder: zero(),
                command: Angle::ZERO,
            };
            assert_eq!(application.step(&at_rest).duty, Percent::ZERO);
        }
    }

    #[test]
    fn three_lost_samples_hold_the_duty_and_the_fourth_switches_the_bridge_off() {
        let mut application = enabled();
        let driven = application.step(&samples(zero())).bridge;
        for _ in 0..ENCODER_PATIENCE {
            assert_eq!(application.step(&samples(LOST)).bridge, driven);
        }
        let outputs = application.step(&samples(LOST));
        assert_eq!(outputs.bridge, Bridge::Off);
        assert_eq!(outputs.state, State::Fault(Fault::EncoderLost));
    }

    #[test]
    fn a_fault_stays_until_it_is_acknowledged_and_then_wants_a_new_enable() {
        let mut application = enabled();
        for _ in 0..=ENCODER_PATIENCE {
            application.step(&samples(LOST));
        }
        application.request(Request::Enable);
        assert_eq!(
            application.step(&samples(zero())).state,
            State::Fault(Fault::EncoderLost)
        );
        application.request(Request::Acknowledge);
        assert_eq!(application.state(), State::Disabled);
        // The angle has to be found first.
        application.request(Request::Enable);
        assert_eq!(application.state(), State::Disabled);
        application.step(&samples(zero()));
        application.request(Request::Enable);
        assert_eq!(application.state(), State::Enabled);
    }
}
