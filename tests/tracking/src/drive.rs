//! The control loop of the board in a closed loop with the plant, natively, in cyclic synchronous
//! position mode.

use firmware::application::{Bridge, Outputs, Start};
use firmware::control_loop::{Commands, ExcitationRequest, Inputs, Loop, LoopParameters};
use firmware::native;
use firmware::timing::periods;
use model_core::plant::board::{
    self as plant, BoardPlant, BoardPlantOptions, Defects, SampledBoardPlant,
};

/// A drive that is enabled.
pub struct Drive {
    control_loop: Loop,
    parameters: LoopParameters,
    commands: Commands,
    plant: SampledBoardPlant,
}

impl Drive {
    /// One that has been at rest with the bridge off for 0.4 s, then enabled.
    ///
    /// # Panics
    /// If the options are out of their ranges, or the drive cannot be enabled.
    pub fn enabled(options: &BoardPlantOptions, parameters: &LoopParameters) -> Self {
        let (commands, parameters) = (Commands::new(), *parameters);
        let mailboxes = (&commands, &parameters, &ExcitationRequest::NONE);
        let plant = BoardPlant::try_new(options).expect("in range");
        let mut drive = Self {
            control_loop: Loop::new(mailboxes, Start::default()),
            parameters,
            commands,
            plant: SampledBoardPlant::new(plant, &mut |_, _| {}),
        };
        for _ in 0..periods(400) {
            drive.control_period(0);
        }
        for control in [0x06, 0x07, 0x0f] {
            drive.command(control, 0.0);
            drive.control_period(0);
        }
        assert!(drive.control_period(0).state.is_driving(), "enabled");
        drive
    }

    fn command(&mut self, control: u16, target_deg: f64) {
        let mut command = *self.commands.newest();
        command.control = control;
        command.set_position((target_deg * 1e3).round() as i32);
        let taken = self.control_loop.taken().command;
        assert!(self.commands.set(&command, true, taken));
    }

    /// A control period with so many counts added to the compare value.
    fn control_period(&mut self, added: i32) -> Outputs {
        let samples = native::samples(&self.plant.sampled());
        let outputs = *self.control_loop.step(&Inputs {
            samples: &samples,
            was_late: false,
            commands: &self.commands,
            parameters: &self.parameters,
            excitation: &ExcitationRequest::NONE,
        });
        let bridge = match outputs.bridge {
            Bridge::Driven(compare) => plant::Bridge::driven(compare.get() + added),
            other => native::bridge(other),
        };
        self.plant.tick(bridge, &mut |_, _| {});
        outputs
    }

    /// Sends a target.
    pub fn target(&mut self, target_deg: f64) {
        self.command(0x0f, target_deg);
    }

    /// One control period; returns the duty, %, and the angle of the shaft at its end, deg.
    pub fn step(&mut self) -> (f64, f64) {
        self.step_with(0)
    }

    /// The same with so many counts added to the compare value of the bridge.
    pub fn step_with(&mut self, added: i32) -> (f64, f64) {
        let outputs = self.control_period(added);
        assert!(outputs.fault.is_none(), "{:?}", outputs.fault);
        let duty_pct = outputs.telemetry.duty.to_f64();
        (duty_pct, self.plant.plant.reading().output.angle_deg)
    }

    /// Copper loss since the start, J.
    pub fn copper_loss_j(&self) -> f64 {
        self.plant.plant.copper_loss_j()
    }

    pub fn defects(&mut self) -> &mut Defects {
        &mut self.plant.plant.defects
    }
}
