//! The loop of the board around a model of the identified motor, which follows the recorded
//! command of each control period.

use firmware::application::Start;
use firmware::capture::Signal;
use firmware::control_loop::{Commands, ExcitationRequest, Inputs, Loop, LoopParameters};
use firmware::native;
use firmware::parameters::{BoardParameters, ObjectValues};
use firmware::timing::CONTROL_PERIOD_MS;
use model_core::control::cascade::Coefficients;
use model_core::control::parameters::ControlParameters;
use model_core::control::pwm_timer::PWM_COUNTS;
use model_core::parameter::ParameterError;
use model_core::plant::board::{BoardPlant, BoardPlantOptions, ENCODER_DELAY_S, SampledBoardPlant};
use model_core::time::UPDATE_RATE_HZ;

/// The signals of a recording, in the order of [`Record::of`].
pub const SIGNALS: [Signal; 4] = [
    Signal::Angle,
    Signal::Command,
    Signal::Compare,
    Signal::Supply,
];

/// A control period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record {
    /// Measured angle, deg.
    pub angle_deg: f64,
    /// Commanded angle, mdeg.
    pub command_mdeg: i32,
    /// Mean voltage of the bridge, V.
    pub voltage_v: f64,
    /// Supply, V.
    pub supply_v: f64,
}

impl Record {
    /// That of the values of [`SIGNALS`].
    pub fn of(values: &[i32]) -> Self {
        let supply_v = f64::from(values[3]) * 1e-3;
        Self {
            angle_deg: f64::from(values[0]) * 1e-3,
            command_mdeg: values[1],
            voltage_v: f64::from(values[2]) / f64::from(PWM_COUNTS) * supply_v,
            supply_v,
        }
    }
}

/// Control periods after which the board has measured all that it needs for enabling.
const START: usize = 100;

/// Time from the angle to the duty, s: to the next edge of the PWM, and that of the encoder's word.
pub const DELAY_S: f64 = 1.0 / UPDATE_RATE_HZ as f64 + ENCODER_DELAY_S;

/// Controlwords that enable the drive.
const ENABLE: [u16; 3] = [0x06, 0x07, 0x0F];

/// A board with a motor.
#[derive(Debug, Clone)]
pub struct Twin {
    /// The motor and what it moves.
    pub plant: BoardPlantOptions,
    /// The loop.
    pub control: ControlParameters,
    /// The objects, feed-forward among them.
    pub values: ObjectValues,
}

impl Twin {
    /// Follows the commands of these records, from rest at the first angle.
    pub fn follow(&self, records: &[Record]) -> Result<Vec<Record>, ParameterError> {
        let board = BoardParameters {
            control: Coefficients::try_new(&self.control)?,
            ..BoardParameters::DEFAULT
        };
        let mut values = self.values;
        // A target in each control period.
        values.profile.interpolation_time = CONTROL_PERIOD_MS as u8;
        let parameters = LoopParameters::new(&board, &values);
        let excitation = ExcitationRequest::NONE;
        let mut commands = Commands::new();
        let mut control_loop = Loop::new((&commands, &parameters, &excitation), Start::default());
        let plant = BoardPlant::try_new(&self.plant)?;
        let mut plant = SampledBoardPlant::new(plant, &mut |_, _| {});
        let Some(first) = records.first() else {
            return Ok(Vec::new());
        };
        // The plant starts at an angle of 0.
        let start_mdeg = (first.angle_deg * 1e3).round() as i32;
        let mut period = |control: u16, target_mdeg: i32| {
            let mut command = *commands.newest();
            command.control = control;
            command.set_position(target_mdeg - start_mdeg);
            // The queue holds more than the one command of each control period.
            let _ = commands.set(&command, true, control_loop.taken().command);
            let outputs = *control_loop.step(&Inputs {
                samples: &native::samples(&plant.sampled()),
                was_late: false,
                commands: &commands,
                parameters: &parameters,
                excitation: &excitation,
            });
            plant.tick(native::bridge(outputs.bridge), &mut |_, _| {});
            let record = Record::of(&SIGNALS.map(|signal| signal.of(&outputs)));
            Record {
                angle_deg: record.angle_deg + f64::from(start_mdeg) * 1e-3,
                command_mdeg: record.command_mdeg + start_mdeg,
                ..record
            }
        };
        for _ in 0..START {
            period(0, first.command_mdeg);
        }
        for control in ENABLE {
            period(control, first.command_mdeg);
        }
        let followed = records.iter();
        Ok(followed
            .map(|record| period(ENABLE[2], record.command_mdeg))
            .collect())
    }
}
