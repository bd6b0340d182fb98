//! The plant in control periods, in the order in which the board samples and drives.

use super::{BoardPlant, Bridge, Sensed, Slot};
use crate::sensors::adc::AdcCode;
use crate::time::PWM_PERIODS_PER_CONTROL_PERIOD;

/// PWM periods in a control period.
const PERIODS: u32 = PWM_PERIODS_PER_CONTROL_PERIOD;

/// What the board has sampled when a control period begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sampled {
    /// What the pins show at the edge at which it begins; the encoder is read there.
    pub sensed: Sensed,
    /// The motor current at the start of the last PWM period; none before the first control period.
    pub current: Option<AdcCode>,
    /// What the window of the last PWM period saw, the legs while the bridge was open, with the
    /// supply beside the current; none before the first.
    pub window: Option<Sensed>,
}

/// The plant at the end of a PWM period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// What the bridge did up to it.
    pub bridge: Bridge,
    /// What the pins show from it on.
    pub sensed: Sensed,
}

/// A plant that is driven as a board does it: a decision takes effect one PWM period after the
/// control period began, and the bridge is open in the window at the end of the last of its PWM
/// periods.
#[derive(Debug, Clone)]
pub struct SampledBoardPlant {
    /// The plant.
    pub plant: BoardPlant,
    bridge: Bridge,
    sampled: Sampled,
}

impl SampledBoardPlant {
    /// After power-on: one PWM period passes before the first control period.
    pub fn new(mut plant: BoardPlant, see: &mut impl FnMut(&BoardPlant, Edge)) -> Self {
        let sensed = plant.sense();
        let mut ticked = Self {
            plant,
            bridge: Bridge::Coast,
            sampled: Sampled {
                sensed,
                current: None,
                window: None,
            },
        };
        ticked.period(false, see);
        ticked
    }

    /// What has been sampled for the control period that begins.
    pub fn sampled(&self) -> Sampled {
        self.sampled
    }

    /// A control period, in which this was decided; `see` sees the plant at the end of each of its
    /// PWM periods.
    ///
    /// ```
    /// use model_core::plant::board::{Bridge, BoardPlant, BoardPlantOptions, SampledBoardPlant};
    ///
    /// let mut edges = 0;
    /// let mut see = |_: &BoardPlant, _| edges += 1;
    /// let plant = BoardPlant::try_new(&BoardPlantOptions::default()).unwrap();
    /// let mut ticked = SampledBoardPlant::new(plant, &mut see);
    /// ticked.tick(Bridge::driven(28_000), &mut see);
    /// assert_eq!(edges, 5);
    /// ```
    pub fn tick(&mut self, decided: Bridge, see: &mut impl FnMut(&BoardPlant, Edge)) {
        (self.sampled.current, self.sampled.window) = (None, None);
        self.period(false, see);
        // The compare values are preloaded: they take effect at the next edge.
        self.bridge = decided;
        for period in 1..PERIODS {
            self.period(period + 1 == PERIODS, see);
        }
    }

    /// A PWM period; in the last of a tick the window opens, and the converter runs.
    fn period(&mut self, has_window: bool, see: &mut impl FnMut(&BoardPlant, Edge)) {
        if has_window {
            self.sampled.current = Some(self.sampled.sensed.current);
        }
        let supply = self.sampled.sensed.supply;
        self.plant.advance(self.bridge, Slot::Head);
        let within = self.plant.sense();
        let bridge = if has_window {
            let legs = self.plant.sense_legs(Bridge::Coast);
            self.sampled.window = Some(Sensed {
                legs,
                supply,
                ..within
            });
            Bridge::Coast
        } else {
            self.bridge
        };
        self.plant.advance(bridge, Slot::Tail);
        self.sampled.sensed = self.plant.sense();
        let edge = Edge {
            bridge,
            sensed: self.sampled.sensed,
        };
        see(&self.plant, edge);
    }
}
