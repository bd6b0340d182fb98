//! The application on the PC, on the rig of the emulated board, in the board's order.

use firmware::application::{Application, Samples};
use firmware::capture::Capture;
use firmware::frames::Frames;
use firmware::native::{bridge, samples};
use firmware::parameters::BoardParameters;
use firmware::service::Service;
use virtual_board::rig::{Bridge, Edge, Rig, RigOptions, Sensed, TickedRig};
use virtual_board::trace;

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

impl Row {
    pub(crate) fn of(rig: &Rig, Edge { bridge, sensed }: Edge) -> Self {
        Self {
            bridge,
            sensed,
            angle_deg: rig.reading().output.angle_deg,
        }
    }
}

impl Row {
    /// Whether the emulated board did the same, bit for bit.
    fn is(&self, emulated: &trace::Row) -> bool {
        emulated.bridge == self.bridge
            && emulated.sensed == self.sensed
            && emulated.angle_deg.to_bits() == self.angle_deg.to_bits()
    }
}

/// Asserts that the emulated board did the same in every PWM period, bit for bit.
///
/// # Panics
/// If it did not.
pub fn assert_same(native: &[Row], emulated: &[trace::Row]) {
    for (period, (expected, found)) in native.iter().zip(emulated).enumerate() {
        assert!(
            expected.is(found),
            "period {period}: native {expected:?}, emulated {found:?}"
        );
    }
}

/// The native run.
pub struct Native {
    /// A row for each PWM period.
    pub rows: Vec<Row>,
    /// The telemetry of each control period.
    pub telemetry: Vec<[Frame; 3]>,
    rig: TickedRig,
    application: Application,
    frames: Frames,
    service: Service,
}

impl Native {
    /// A board after power-on, up to its first control period: a PWM period has passed by then.
    ///
    /// # Panics
    /// If a parameter of the rig is outside its range.
    pub fn new(options: &RigOptions) -> Self {
        let mut rows = Vec::new();
        let rig = Rig::try_new(options).expect("in range");
        let rig = TickedRig::new(rig, &mut |rig, edge| rows.push(Row::of(rig, edge)));
        Self {
            rows,
            telemetry: Vec::new(),
            rig,
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
        let samples: Samples = samples(&self.rig.sampled());
        let outputs = self.application.step(&samples);
        let telemetry = self.frames.telemetry::<Frame>(&outputs);
        self.telemetry
            .push(telemetry.map(|frame| frame.expect("fits")));
        let rows = &mut self.rows;
        self.rig.tick(bridge(outputs.bridge), &mut |rig, edge| {
            rows.push(Row::of(rig, edge));
        });
    }
}
