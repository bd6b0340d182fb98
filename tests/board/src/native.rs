//! The application on the PC, on the plant of the emulated board, in the board's order.

use firmware::application::Application;
use firmware::capture::Capture;
use firmware::frames::Frames;
use firmware::parameters::BoardParameters;
use firmware::service::Service;
use virtual_board::plant::BoardPlantOptions;

use crate::frames::Frame;
use crate::native_plant::NativePlant;

/// The native run.
pub struct Native {
    /// The plant.
    pub plant: NativePlant,
    /// The telemetry of each control period.
    pub telemetry: Vec<[Frame; 3]>,
    application: Application,
    frames: Frames,
    service: Service,
}

impl Native {
    /// A board after power-on, up to its first control period: a PWM period has passed by then.
    ///
    /// # Panics
    /// If a parameter of the plant is outside its range.
    pub fn new(options: &BoardPlantOptions) -> Self {
        Self {
            plant: NativePlant::new(options),
            telemetry: Vec::new(),
            application: Application::new(BoardParameters::DEFAULT),
            frames: Frames::new(1),
            service: Service::default(),
        }
    }

    /// A control period with the four PWM periods behind it; the frame came in before it.
    ///
    /// # Panics
    /// If the application makes no telemetry.
    pub fn tick(&mut self, frame: Option<&Frame>) {
        if let Some(message) = frame.and_then(|frame| self.frames.receive(frame)) {
            let capture = &mut Capture::new(&mut []);
            (self.service).serve(&mut self.application, capture, &message);
        }
        let outputs = self.application.step(&self.plant.samples());
        let telemetry = self.frames.telemetry::<Frame>(&outputs);
        self.telemetry
            .push(telemetry.map(|frame| frame.expect("fits")));
        self.plant.tick(outputs.bridge);
    }
}
