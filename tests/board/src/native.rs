//! The application on the PC, on the rig of the emulated board, in the board's order.

use firmware::application::{self, Application, BusState, Samples, Scan};
use firmware::capture::Capture;
use firmware::frames::Frames;
use firmware::parameters::BoardParameters;
use firmware::service::Service;
use model_core::sensors::adc::AdcCode;
use virtual_board::rig::{Bridge, Rig, RigOptions, Sensed, Slot};

use crate::frames::Frame;

/// The rig at the start of a PWM period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// What the bridge did up to it.
    pub bridge: Bridge,
    /// What the pins show from it on.
    pub sensed: Sensed,
    /// Angle of the shaft, deg.
    pub angle_deg: f64,
}

/// The native run.
pub struct Native {
    /// A row for each PWM period.
    pub rows: Vec<Row>,
    /// The telemetry of each control period.
    pub telemetry: Vec<[Frame; 3]>,
    rig: Rig,
    application: Application,
    frames: Frames,
    service: Service,
    sensed: Sensed,
    current: Option<AdcCode>,
    scan: Option<Scan>,
    bridge: Bridge,
}

impl Native {
    /// A board after power-on, up to its first control period: a PWM period has passed by then.
    ///
    /// # Panics
    /// If a parameter of the rig is outside its range.
    pub fn new(options: &RigOptions) -> Self {
        let mut rig = Rig::try_new(options).expect("in range");
        let sensed = rig.sense();
        let mut native = Self {
            rows: Vec::new(),
            telemetry: Vec::new(),
            rig,
            application: Application::new(BoardParameters::DEFAULT),
            frames: Frames::new(1),
            service: Service::default(),
            sensed,
            current: None,
            scan: None,
            bridge: Bridge::Coast,
        };
        native.period(false);
        native
    }

    /// A PWM period; in the last of a tick the window opens, and the converter runs.
    fn period(&mut self, has_window: bool) {
        if has_window {
            self.current = Some(self.sensed.current);
        }
        self.rig.advance(self.bridge, Slot::Head);
        let within = self.rig.sense();
        let bridge = if has_window {
            let legs = self.rig.sense_legs(Bridge::Coast);
            self.scan = Some(Scan {
                leg_a: legs.a,
                leg_b: legs.b,
                supply: within.supply,
                temperature: within.temperature,
            });
            Bridge::Coast
        } else {
            self.bridge
        };
        self.rig.advance(bridge, Slot::Tail);
        self.sensed = self.rig.sense();
        self.rows.push(Row {
            bridge,
            sensed: self.sensed,
            angle_deg: self.rig.reading().output.angle_deg,
        });
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
        let outputs = self.application.step(&Samples {
            encoder: Some(self.sensed.encoder.word()),
            current: self.current.take(),
            scan: self.scan.take(),
            servo_pulse_us: None,
            bridge_tripped: false,
            missed_periods: 0,
            bus: BusState::Active,
        });
        let telemetry = self.frames.telemetry::<Frame>(&outputs);
        self.telemetry
            .push(telemetry.map(|frame| frame.expect("fits")));
        self.period(false);
        // The compare values are preloaded: they take effect at the next edge.
        self.bridge = match outputs.bridge {
            application::Bridge::Coast => Bridge::Coast,
            application::Bridge::Brake => Bridge::Brake,
            application::Bridge::Driven(compare) => Bridge::driven(compare.get()),
        };
        self.period(false);
        self.period(false);
        self.period(true);
    }
}
