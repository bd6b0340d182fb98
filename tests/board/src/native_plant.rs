//! The plant of the emulated board on the PC, with what it did in every PWM period.

use firmware::application::{self, Samples};
use firmware::native;
use virtual_board::plant::{
    BoardPlant, BoardPlantOptions, Bridge, Edge, SampledBoardPlant, Sensed,
};
use virtual_board::trace;

/// The plant at the start of a PWM period.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Row {
    /// What the bridge did up to it.
    bridge: Bridge,
    /// What the pins show from it on.
    sensed: Sensed,
    /// Angle of the shaft, deg.
    angle_deg: f64,
}

impl Row {
    fn of(plant: &BoardPlant, Edge { bridge, sensed }: Edge) -> Self {
        Self {
            bridge,
            sensed,
            angle_deg: plant.reading().output.angle_deg,
        }
    }

    /// Whether the emulated board did the same, bit for bit.
    fn is(&self, emulated: &trace::Row) -> bool {
        emulated.bridge == self.bridge
            && emulated.sensed == self.sensed
            && emulated.angle_deg.to_bits() == self.angle_deg.to_bits()
    }
}

/// The plant.
pub struct NativePlant {
    plant: SampledBoardPlant,
    rows: Vec<Row>,
}

impl NativePlant {
    /// That of a board after power-on, up to its first control period: a PWM period has passed by then.
    ///
    /// # Panics
    /// If a parameter of the plant is outside its range.
    pub fn new(options: &BoardPlantOptions) -> Self {
        let mut rows = Vec::new();
        let plant = BoardPlant::try_new(options).expect("in range");
        let plant =
            SampledBoardPlant::new(plant, &mut |plant, edge| rows.push(Row::of(plant, edge)));
        Self { plant, rows }
    }

    /// What the control period that begins gets.
    pub fn samples(&self) -> Samples {
        native::samples(&self.plant.sampled())
    }

    /// The four PWM periods of a control period that decided this.
    pub fn tick(&mut self, decided: application::Bridge) {
        let Self { plant, rows } = self;
        plant.tick(native::bridge(decided), &mut |plant, edge| {
            rows.push(Row::of(plant, edge));
        });
    }

    /// Asserts that the emulated board did the same in every PWM period, bit for bit.
    ///
    /// # Panics
    /// If it did not.
    pub fn assert_same(&self, emulated: &[trace::Row]) {
        for (period, (expected, found)) in self.rows.iter().zip(emulated).enumerate() {
            assert!(
                expected.is(found),
                "period {period}: native {expected:?}, emulated {found:?}"
            );
        }
    }
}
