//! What stands in for the bench: motors, gear train, friction and load.
//!
//! A plant is driven by PWM periods of 20 ticks. The duty of a period is latched at its start and
//! holds until its end, so a plant knows then all that happens within the period, and any of its
//! ticks can be looked at without changing what follows.

pub mod board;
pub mod drivetrain;
pub mod first_order;

use crate::limits::within;
use crate::named::named;
use crate::time::PWM_PERIOD_TICKS;

/// Ticks in one PWM period, as an index.
pub const PERIOD: usize = PWM_PERIOD_TICKS as usize;

named! {
    /// What the bridge does with a duty.
    Pwm {
        /// The mean voltage of the duty all through the period.
        Average = "average",
        /// Edge-aligned sign-magnitude switching: the whole supply for |duty|/100 of the period
        /// from its start, then off. An edge between two ticks is taken where it is.
        Switched = "switched",
    }
}

/// What the encoder could see of a plant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PlantState {
    /// Angle of the output shaft, deg.
    pub angle_deg: f64,
    /// Rate of the output shaft, deg/s.
    pub rate_deg_s: f64,
}

/// A motor and what it moves, from the duty of the bridge to the output shaft.
pub trait Plant {
    /// The PWM latch: closes the running period and starts the next with this duty, %.
    ///
    /// The duty is limited to +-100 %; NaN is taken as 0.
    fn start_period(&mut self, duty_pct: f64);

    /// The state at a tick of the running period, from 0 to 20; later ticks give that of 20.
    ///
    /// `at(20)` of a period is `at(0)` of the next to the last bit.
    fn at(&self, tick_in_period: usize) -> PlantState;
}

/// A duty that a bridge can follow: limited to +-100 %, 0 for NaN.
pub(crate) fn bridge_duty_pct(duty_pct: f64) -> f64 {
    if duty_pct.is_nan() {
        0.0
    } else {
        within(duty_pct, -100.0, 100.0)
    }
}
