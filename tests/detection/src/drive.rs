//! The application of the board in a closed loop with the plant, natively.

use firmware::application::{
    Application, DeadBandSettings, MotorLimits, Outputs, Request, Samples, Settings, Start,
};
use firmware::faults::FaultSet;
use firmware::measure::MotorConstants;
use firmware::native;
use firmware::parameters::{BoardParameters, LimitSettings, ModelSettings};
use firmware::timing::CONTROL_PERIOD_MS;
use model_core::control::encoder_correction::EncoderCorrection;
use model_core::control::units::{Angle, angle};
use model_core::plant::board::{BoardPlant, BoardPlantOptions, Defects, SampledBoardPlant};

/// Length of a control period, s.
pub const PERIOD_S: f64 = CONTROL_PERIOD_MS as f64 * 1e-3;

/// What the shaft does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Task {
    /// It is held at 20 deg.
    Held,
    /// The same under 0.3 N m, a third of the stall torque.
    Loaded,
    /// It moves between 30 and -30 deg, sinusoidally at 0.5 Hz.
    Moving,
}

impl Task {
    pub const ALL: [Self; 3] = [Self::Held, Self::Loaded, Self::Moving];

    pub fn name(self) -> &'static str {
        match self {
            Self::Held => "held",
            Self::Loaded => "held under 0.3 N m",
            Self::Moving => "moving",
        }
    }

    fn command(self, period: u32) -> Angle {
        match self {
            Self::Held | Self::Loaded => angle(20.0),
            Self::Moving => {
                let turns = 0.5 * PERIOD_S * f64::from(period);
                angle(30.0 * (turns * core::f64::consts::TAU).sin())
            }
        }
    }

    /// Torque from outside, N m.
    pub fn torque_nm(self) -> f64 {
        if self == Self::Loaded { -0.3 } else { 0.0 }
    }
}

/// A drive with the default parameters on a plant.
pub struct Drive {
    application: Application,
    parameters: BoardParameters,
    motor: MotorConstants,
    limits: MotorLimits,
    plant: SampledBoardPlant,
    period: u32,
    /// Those of the last control period.
    pub outputs: Outputs,
}

impl Drive {
    /// One that has been at rest with the bridge off for 0.4 s, then enabled.
    ///
    /// # Panics
    /// If the options are out of their ranges.
    pub fn enabled(options: &BoardPlantOptions) -> Self {
        let (parameters, model) = (BoardParameters::DEFAULT, ModelSettings::DEFAULT);
        let plant = BoardPlant::try_new(options).expect("in range");
        let mut drive = Self {
            application: Application::new(&parameters, Start::default()),
            limits: MotorLimits::of(&LimitSettings::DEFAULT, &parameters, &model),
            motor: MotorConstants::of(&model),
            parameters,
            plant: SampledBoardPlant::new(plant, &mut |_, _| {}),
            period: 0,
            outputs: Outputs::default(),
        };
        for _ in 0..100 {
            drive.control_period();
        }
        drive
            .application
            .request(Request::Enable)
            .expect("no fault");
        drive
    }

    fn control_period(&mut self) {
        let settings = Settings {
            board: &self.parameters,
            motor: &self.motor,
            limits: &self.limits,
            dead_band: &DeadBandSettings::default(),
            encoder: &EncoderCorrection::NONE,
            observes_rate: false,
        };
        let samples: Samples = native::samples(&self.plant.sampled());
        self.outputs = *self.application.control_period(settings, &samples);
        (self.plant).tick(native::bridge(self.outputs.bridge), &mut |_, _| {});
    }

    /// One control period with this command; returns the latched faults.
    pub fn follow(&mut self, command: Angle) -> FaultSet {
        // Refused after a fault.
        let _ = self.application.request(Request::Command(command.into()));
        self.control_period();
        self.outputs.telemetry.latched
    }

    /// One control period of a task.
    pub fn perform(&mut self, task: Task) -> FaultSet {
        self.period += 1;
        self.follow(task.command(self.period))
    }

    pub fn defects(&mut self) -> &mut Defects {
        &mut self.plant.plant.defects
    }

    /// The angle of the shaft, deg.
    pub fn angle_deg(&self) -> f64 {
        self.plant.plant.reading().output.angle_deg
    }
}
