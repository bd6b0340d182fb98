//! The actuator run natively on the PC, with the plant and the execution order of the emulated board.

use firmware::actuator::Actuator;
use firmware::application::Start;
use firmware::drive::StoredParameters;
use firmware::native;
use firmware::timing::COMMUNICATION_PERIODS;
use model_core::time::{CONTROL_RATE_HZ, UPDATE_PERIOD_NS, UPDATE_PERIODS_PER_CONTROL_PERIOD};
use virtual_board::faults::{Change, Injector, Planned};
use virtual_board::plant::{
    BoardPlant, BoardPlantOptions, Bridge, Edge, SampledBoardPlant, Sensed,
};
use virtual_board::trace;

use crate::frames::Frame;
use crate::master::TICK_RATE_HZ;

/// Control periods in a tick.
const CONTROL_PERIODS: u64 = (CONTROL_RATE_HZ / TICK_RATE_HZ) as u64;

/// The plant at the start of an update period.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Row {
    /// State of the bridge up to it.
    bridge: Bridge,
    /// Sensor values from it on.
    sensed: Sensed,
    /// Angle of the shaft, deg.
    angle_deg: f64,
    /// Rate of the shaft, deg/s.
    rate_deg_s: f64,
}

impl Row {
    fn of(plant: &BoardPlant, Edge { bridge, sensed }: Edge) -> Self {
        let output = plant.reading().output;
        Self {
            bridge,
            sensed,
            angle_deg: output.angle_deg,
            rate_deg_s: output.rate_deg_s,
        }
    }

    /// Whether the row of the emulated board is the same, bit for bit.
    fn equals(&self, emulated: &trace::Row) -> bool {
        emulated.bridge == self.bridge
            && emulated.sensed == self.sensed
            && emulated.angle_deg.to_bits() == self.angle_deg.to_bits()
    }
}

/// The native run.
pub struct NativeBoard {
    /// Every transmitted frame.
    pub frames: Vec<Frame>,
    plant: SampledBoardPlant,
    rows: Vec<Row>,
    actuator: Actuator<'static>,
    tick: u64,
    faults: Injector,
}

impl NativeBoard {
    /// A board after power-on, up to its first control period: an update period has passed by then.
    ///
    /// # Panics
    /// If a parameter of the plant is outside its range.
    pub fn new(options: &BoardPlantOptions) -> Self {
        let mut rows = Vec::new();
        let plant = BoardPlant::try_new(options).expect("in range");
        let plant =
            SampledBoardPlant::new(plant, &mut |plant, edge| rows.push(Row::of(plant, edge)));
        Self {
            frames: Vec::new(),
            plant,
            rows,
            actuator: Actuator::new(StoredParameters::DEFAULT, Start::default(), &mut [], 0),
            tick: 0,
            faults: Injector::default(),
        }
    }

    /// The same with faults of the plant, each from the next update on.
    #[must_use]
    pub fn with_faults(self, plan: Vec<Planned>) -> Self {
        Self {
            faults: Injector::new(plan),
            ..self
        }
    }

    /// Angles, deg, and rates, deg/s, of the shaft at each update.
    pub fn motion(&self) -> impl Iterator<Item = (f64, f64)> {
        self.rows.iter().map(|row| (row.angle_deg, row.rate_deg_s))
    }

    /// Runs a tick of the master; these frames arrive before its first communication cycle.
    pub fn tick(&mut self, frames: &[Frame]) {
        for period in 0..CONTROL_PERIODS {
            let frames = if period == 0 { frames } else { &[] };
            self.control_period(CONTROL_PERIODS * self.tick + period, frames);
        }
        self.tick += 1;
    }

    /// Runs the control period of this number.
    fn control_period(&mut self, number: u64, frames: &[Frame]) {
        let samples = native::samples(&self.plant.sampled());
        let outputs = self.actuator.control_period(&samples);
        let [first, second] = COMMUNICATION_PERIODS;
        self.communicate((number, first), frames);
        self.communicate((number, second), &[]);
        let (rows, faults) = (&mut self.rows, &mut self.faults);
        self.plant
            .tick(native::bridge(outputs.bridge), &mut |plant, edge| {
                rows.push(Row::of(plant, edge));
                let now_ns = rows.len() as u64 * UPDATE_PERIOD_NS;
                for Change { fault, begins } in faults.due(now_ns, 0) {
                    fault.apply_to(&mut plant.defects, begins);
                }
            });
    }

    /// The communication cycle in this update period of a control period.
    fn communicate(&mut self, (number, update): (u64, u32), frames: &[Frame]) {
        let updates = u64::from(UPDATE_PERIODS_PER_CONTROL_PERIOD) * number + u64::from(update);
        let now_us = updates * UPDATE_PERIOD_NS / 1000;
        for frame in frames {
            self.actuator.receive(frame, now_us);
            self.transmit();
        }
        self.actuator.communicate(now_us);
        self.transmit();
    }

    fn transmit(&mut self) {
        while let Some(frame) = self.actuator.transmit() {
            self.frames.push(frame);
        }
    }

    /// Asserts that the plant of the emulated board was bit-exactly the same in every update
    /// period.
    ///
    /// # Panics
    /// If it was not.
    pub fn assert_same(&self, emulated: &[trace::Row]) {
        for (period, (expected, found)) in self.rows.iter().zip(emulated).enumerate() {
            assert!(
                expected.equals(found),
                "period {period}: native {expected:?}, emulated {found:?}"
            );
        }
    }
}
