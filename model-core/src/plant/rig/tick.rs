//! The rig in control periods, in the order in which the board samples and drives.

use super::{Bridge, Rig, Sensed, Slot};
use crate::sensors::adc::AdcCode;

/// PWM periods in a control period.
const PERIODS: usize = 4;

/// What the board has sampled when a control period begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sampled {
    /// What the pins show at the edge at which it begins; the encoder is read there.
    pub sensed: Sensed,
    /// The motor current at the start of the last PWM period; none before the first control period.
    pub current: Option<AdcCode>,
    /// What the window of the last PWM period saw, the legs while the bridge was open, with the supply beside the
    /// current; none before the first.
    pub window: Option<Sensed>,
}

/// The rig at the end of a PWM period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// What the bridge did up to it.
    pub bridge: Bridge,
    /// What the pins show from it on.
    pub sensed: Sensed,
}

/// A rig that is driven as a board does it: a decision takes effect one PWM period after the control period began, and the
/// bridge is open in the window at the end of the last of its four PWM periods.
#[derive(Debug, Clone)]
pub struct TickedRig {
    /// The rig.
    pub rig: Rig,
    bridge: Bridge,
    sampled: Sampled,
}

impl TickedRig {
    /// After power-on: one PWM period passes before the first control period.
    pub fn new(mut rig: Rig, see: &mut impl FnMut(&Rig, Edge)) -> Self {
        let sensed = rig.sense();
        let mut ticked = Self {
            rig,
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

    /// A control period, in which this was decided; `see` sees the rig at the end of each of its PWM periods.
    ///
    /// ```
    /// use model_core::plant::rig::{Bridge, Rig, RigOptions, TickedRig};
    ///
    /// let mut edges = 0;
    /// let mut see = |_: &Rig, _| edges += 1;
    /// let rig = Rig::try_new(&RigOptions::default()).unwrap();
    /// let mut ticked = TickedRig::new(rig, &mut see);
    /// ticked.tick(Bridge::driven(28_000), &mut see);
    /// assert_eq!(edges, 5);
    /// ```
    pub fn tick(&mut self, decided: Bridge, see: &mut impl FnMut(&Rig, Edge)) {
        (self.sampled.current, self.sampled.window) = (None, None);
        self.period(false, see);
        // The compare values are preloaded: they take effect at the next edge.
        self.bridge = decided;
        for period in 1..PERIODS {
            self.period(period + 1 == PERIODS, see);
        }
    }

    /// A PWM period; in the last of a tick the window opens, and the converter runs.
    fn period(&mut self, has_window: bool, see: &mut impl FnMut(&Rig, Edge)) {
        if has_window {
            self.sampled.current = Some(self.sampled.sensed.current);
        }
        let supply = self.sampled.sensed.supply;
        self.rig.advance(self.bridge, Slot::Head);
        let within = self.rig.sense();
        let bridge = if has_window {
            let legs = self.rig.sense_legs(Bridge::Coast);
            self.sampled.window = Some(Sensed {
                legs,
                supply,
                ..within
            });
            Bridge::Coast
        } else {
            self.bridge
        };
        self.rig.advance(bridge, Slot::Tail);
        self.sampled.sensed = self.rig.sense();
        let edge = Edge {
            bridge,
            sensed: self.sampled.sensed,
        };
        see(&self.rig, edge);
    }
}
