//! The plant in control periods, in the order in which the board samples and drives.

use super::{BoardPlant, Bridge, Sensed, Slot};
use crate::time::{CONTROL_PERIODS_PER_WINDOW, UPDATE_PERIODS_PER_CONTROL_PERIOD as PERIODS};

/// The samples of the board when a control period begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sampled {
    /// The samples up to the edge at which it begins; the encoder is read there.
    pub sensed: Sensed,
    /// The conversions of current and supply in the last update period; `None` before the first
    /// control period.
    pub converted: Option<Sensed>,
    /// The scan in the last coast window; `None` before the first one.
    pub scanned: Option<Sensed>,
    /// Whether that window was before an earlier control period.
    pub holds_scan: bool,
}

/// The plant at the end of an update period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// State of the bridge up to it.
    pub bridge: Bridge,
    /// The samples up to it.
    pub sensed: Sensed,
}

/// A plant that is driven as a board does it: a decision takes effect one update period after the
/// control period began, and the bridge is open in the window at the end of the last update period
/// of every [`CONTROL_PERIODS_PER_WINDOW`] control periods.
#[derive(Debug, Clone)]
pub struct SampledBoardPlant {
    /// The plant.
    pub plant: BoardPlant,
    bridge: Bridge,
    sampled: Sampled,
    /// Control periods since the one with the last window.
    since_window: u32,
}

impl SampledBoardPlant {
    /// After power-on: one update period passes before the first control period.
    pub fn new(plant: BoardPlant, see: &mut impl FnMut(&mut BoardPlant, Edge)) -> Self {
        let sensed = plant.sensed();
        let mut ticked = Self {
            plant,
            bridge: Bridge::Coast,
            sampled: Sampled {
                sensed,
                converted: None,
                scanned: None,
                holds_scan: false,
            },
            since_window: 0,
        };
        ticked.update_period(false, see);
        ticked
    }

    /// What has been sampled for the control period that begins.
    pub fn sampled(&self) -> Sampled {
        self.sampled
    }

    /// A control period, in which this was decided; `see` sees the plant at the end of each of its
    /// update periods.
    ///
    /// ```
    /// use model_core::plant::board::{Bridge, BoardPlant, BoardPlantOptions, SampledBoardPlant};
    ///
    /// let mut edges = 0;
    /// let mut see = |_: &mut BoardPlant, _| edges += 1;
    /// let plant = BoardPlant::try_new(&BoardPlantOptions::default()).unwrap();
    /// let mut ticked = SampledBoardPlant::new(plant, &mut see);
    /// ticked.tick(Bridge::driven(28_000), &mut see);
    /// assert_eq!(edges, 5);
    /// ```
    pub fn tick(&mut self, decided: Bridge, see: &mut impl FnMut(&mut BoardPlant, Edge)) {
        self.since_window += 1;
        let has_window = self.since_window == CONTROL_PERIODS_PER_WINDOW;
        self.update_period(false, see);
        // The compare values are preloaded: they take effect at the next edge.
        self.bridge = decided;
        for period in 1..PERIODS {
            self.update_period(has_window && period + 1 == PERIODS, see);
        }
        self.sampled.converted = Some(self.sampled.sensed);
        self.sampled.holds_scan = !has_window;
        if has_window {
            self.sampled.scanned = Some(self.sampled.sensed);
            self.since_window = 0;
        }
    }

    /// An update period; in that with the coast window the bridge opens.
    fn update_period(&mut self, has_window: bool, see: &mut impl FnMut(&mut BoardPlant, Edge)) {
        let current = self.bridge.current_instant();
        let mut bridge = self.bridge;
        for slot in Slot::ALL {
            if has_window && slot == Slot::Legs {
                bridge = Bridge::Coast;
            }
            self.plant.advance(bridge, slot, current);
        }
        let sensed = self.plant.sensed();
        self.sampled.sensed = sensed;
        see(&mut self.plant, Edge { bridge, sensed });
    }
}
