//! The parameters of the control loop, as one message.

use canopen::cia402::Parameters as AxisParameters;
use model_core::control::encoder_correction::{EncoderCorrection, EncoderHarmonics};

use super::{
    axis_parameters::{Polarity, axis_parameters},
    feed_forward::ForwardGains,
};
use crate::{
    application::{DeadBandSettings, MotorLimits},
    drive::StoredParameters,
    interface::Settings,
    measure::MotorConstants,
    parameters::{BoardParameters, FailsafeSettings, ObjectValues},
};

/// Everything that the loop uses and a front end can set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LoopParameters {
    /// Number of the message; another number is a new message. Wraps.
    pub number: u32,
    /// Control law, protections, command sources.
    pub board: BoardParameters,
    /// Profiles, limits and options of the axis.
    pub axis: AxisParameters,
    /// The reaction to the loss of the master.
    pub failsafe: FailsafeSettings,
    /// The position at which the encoder is at 0 when the loop starts, mdeg.
    pub origin_mdeg: i32,
    /// The constants of the motor.
    pub motor: MotorConstants,
    /// The limits of current and temperature.
    pub limits: MotorLimits,
    /// What is fed forward.
    pub forward: ForwardGains,
    /// The dead band at rest.
    pub dead_band: DeadBandSettings,
    /// The error of the encoder.
    pub encoder: EncoderCorrection,
    /// Whether the rate of the control law changes with the back-EMF.
    pub observes_rate: bool,
}

impl LoopParameters {
    /// Those of a stored set, as message 0.
    pub fn of(stored: &StoredParameters) -> Self {
        Self::new(&stored.board, stored.values())
    }

    /// Those of these parameters and values, as message 0.
    pub fn new(board: &BoardParameters, values: &ObjectValues) -> Self {
        Self {
            number: 0,
            board: *board,
            axis: axis_parameters(values, board),
            failsafe: failsafe(values),
            origin_mdeg: values.homing.origin_mdeg,
            motor: MotorConstants::of(&values.model),
            limits: MotorLimits::of(&values.limits, board, &values.model),
            forward: ForwardGains::of(values),
            dead_band: dead_band(values),
            encoder: encoder(values, board),
            observes_rate: values.tracking.rate_observer != 0,
        }
    }

    /// Those of the application.
    pub(super) fn settings(&self) -> Settings<'_> {
        Settings {
            board: &self.board,
            motor: &self.motor,
            limits: &self.limits,
            dead_band: &self.dead_band,
            encoder: &self.encoder,
            observes_rate: self.observes_rate,
        }
    }

    /// Takes over the values of objects: profile, reaction to the loss of the master, limits of
    /// torque and current, motor, and encoder.
    pub(crate) fn set_values(&mut self, values: &ObjectValues) {
        self.axis = axis_parameters(values, &self.board);
        self.failsafe = failsafe(values);
        self.limits = MotorLimits::of(&values.limits, &self.board, &values.model);
        self.motor = MotorConstants::of(&values.model);
        self.forward = ForwardGains::of(values);
        self.dead_band = dead_band(values);
        self.encoder = encoder(values, &self.board);
        self.observes_rate = values.tracking.rate_observer != 0;
    }
}

fn dead_band(values: &ObjectValues) -> DeadBandSettings {
    let model = &values.model;
    let amperes = model.coulomb_friction_nm / (model.torque_constant_nm_a * model.gear_ratio);
    let friction_mv = (1e3 * model.resistance_ohm * amperes).clamp(0.0, 33_000.0);
    DeadBandSettings::new(values.tracking.dead_band_mdeg, friction_mv as i32)
}

fn encoder(values: &ObjectValues, board: &BoardParameters) -> EncoderCorrection {
    let encoder = &values.encoder;
    let harmonics = EncoderHarmonics {
        first_mdeg: (encoder.cosine_once_mdeg, encoder.sine_once_mdeg),
        second_mdeg: (encoder.cosine_twice_mdeg, encoder.sine_twice_mdeg),
    };
    EncoderCorrection::new(&harmonics, board.control.mounting())
}

/// The reaction to the loss of the master, with the position as the axis counts it.
fn failsafe(values: &ObjectValues) -> FailsafeSettings {
    let mut failsafe = values.failsafe;
    failsafe.failsafe_position_mdeg *= Polarity::of(values).position;
    failsafe
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        application::{BoardState, Samples, Start},
        control_loop::{Commands, ExcitationRequest, Inputs, Loop},
    };
    use model_core::control::encoder_word::{EncoderCount, EncoderWord, Magnet};

    #[test]
    fn a_restart_of_a_driven_loop_begins_with_a_quick_stop() {
        let parameters = LoopParameters::of(&StoredParameters::DEFAULT);
        let (mut commands, excitation) = (Commands::new(), ExcitationRequest::NONE);
        let mut control_loop = Loop::new((&commands, &parameters, &excitation), Start::default());
        let mut step = |commands: &Commands| {
            let outputs = *control_loop.step(&Inputs {
                samples: &Samples::at_rest(EncoderWord::of(EncoderCount::new(0), Magnet::Steady)),
                was_late: false,
                commands,
                parameters: &parameters,
                excitation: &excitation,
            });
            (outputs.state, outputs.taken.restarts)
        };
        for control in [0x06, 0x07, 0x0f, 0x0f] {
            let (taken, mut command) = (commands.number(), *commands.newest());
            command.control = control;
            assert!(commands.set(&command, false, taken));
            step(&commands);
        }
        assert_eq!(step(&commands), (BoardState::Enabled, 0));
        commands.restart();
        assert_eq!(step(&commands), (BoardState::QuickStop, 0));
        let restarted = (0..20).find(|_| step(&commands).1 == 1);
        assert!(restarted.is_some());
    }

    #[test]
    fn another_error_of_the_encoder_waits_until_the_drive_is_off_and_is_no_motion() {
        let before = LoopParameters::of(&StoredParameters::DEFAULT);
        let mut after = LoopParameters {
            number: 1,
            ..before
        };
        let sine = EncoderHarmonics {
            first_mdeg: (0, 1400),
            ..EncoderHarmonics::default()
        };
        after.encoder = EncoderCorrection::new(&sine, before.board.control.mounting());
        let (mut commands, excitation) = (Commands::new(), ExcitationRequest::NONE);
        let mut control_loop = Loop::new((&commands, &before, &excitation), Start::default());
        let quarter_turn = EncoderWord::of(EncoderCount::new(1024), Magnet::Steady);
        // The control words, and the message of parameters; whether it is taken then.
        let steps = [
            (0x06, &before, 0),
            (0x07, &before, 0),
            (0x0f, &before, 0),
            (0x0f, &before, 0),
            (0x0f, &before, 0),
            (0x0f, &after, 0),
            (0x0f, &after, 0),
            (0x06, &after, 0),
            (0x06, &after, 1),
        ];
        for (control, parameters, number) in steps {
            let (taken, mut command) = (commands.number(), *commands.newest());
            command.control = control;
            assert!(commands.set(&command, false, taken));
            let outputs = control_loop.step(&Inputs {
                samples: &Samples::at_rest(quarter_turn),
                was_late: false,
                commands: &commands,
                parameters,
                excitation: &excitation,
            });
            assert_eq!(outputs.taken.parameters, number, "{:?}", outputs.state);
            assert_eq!(outputs.telemetry.velocity_mdeg_s, 0);
            let angle_deg = if number == 0 { 90.0 } else { 88.6 };
            assert!((outputs.telemetry.angle.to_f64() - angle_deg).abs() < 1e-3);
        }
    }

    #[test]
    fn a_restart_takes_the_parameters_of_the_mailbox() {
        let before = LoopParameters::of(&StoredParameters::DEFAULT);
        let (mut commands, excitation) = (Commands::new(), ExcitationRequest::NONE);
        let mut control_loop = Loop::new((&commands, &before, &excitation), Start::default());
        let mut after = LoopParameters {
            number: 1,
            ..before
        };
        after.board.stall.stall_ms += 100;
        commands.restart();
        control_loop.step(&Inputs {
            samples: &Samples::at_rest(EncoderWord::new(0)),
            was_late: false,
            commands: &commands,
            parameters: &after,
            excitation: &excitation,
        });
        assert_eq!(control_loop.parameters(), &after);
    }
}
