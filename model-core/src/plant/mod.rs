//! Models of the physical plant: motors, gear train, friction, load and the board around the
//! processor.
//!
//! A plant is driven by PWM periods of 20 ticks. The duty of a period is latched at its start and
//! constant until its end, so the plant is determined for the whole period, and reading any of its
//! ticks has no side effect.

pub mod board;
pub mod drivetrain;
pub mod first_order;
pub mod lanes;

use crate::limits::within;
use crate::named::named;
use crate::time::UPDATE_PERIOD_TICKS;

/// Ticks in one PWM period, as an index.
pub const PERIOD: usize = UPDATE_PERIOD_TICKS as usize;

named! {
    /// Bridge voltage for a duty.
    Pwm {
        /// The mean voltage of the duty during the whole period.
        Average = "average",
        /// Edge-aligned sign-magnitude switching: the full supply for |duty|/100 of the period from
        /// its start, then off. An edge between two ticks is exact.
        Switched = "switched",
    }
}

/// State of the output shaft of a plant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PlantState {
    /// Angle of the output shaft, deg.
    pub angle_deg: f64,
    /// Rate of the output shaft, deg/s.
    pub rate_deg_s: f64,
}

/// A motor with its mechanics, from the duty of the bridge to the output shaft.
pub trait Plant {
    /// Ends the running PWM period and latches this duty, %, for the next.
    ///
    /// The duty is limited to +-100 %; NaN counts as 0.
    fn start_period(&mut self, duty_pct: f64);

    /// Simulates the running period up to this tick, from 0 to 20, for a plant that is not known in
    /// advance.
    #[inline(always)]
    fn pass_to(&mut self, _tick_in_period: usize) {}

    /// The state at a tick of the running period, from 0 to 20, to which it has passed; later ticks
    /// return that of 20.
    ///
    /// `at(20)` of a period is bit-identical to `at(0)` of the next.
    fn at(&self, tick_in_period: usize) -> PlantState;
}

/// A duty limited to the bridge's range of +-100 %; 0 for NaN.
pub(crate) fn bridge_duty_pct(duty_pct: f64) -> f64 {
    if duty_pct.is_nan() {
        0.0
    } else {
        within(duty_pct, -100.0, 100.0)
    }
}
