//! A shaft that is jammed: the loop demands a rate and drives towards it, and neither shaft nor
//! motor turns.
//!
//! The demand is the error times the gain. At 8/s, [`LEVEL_DEG_S`] is an error of 4.5 deg, by
//! which the motor has moved any load below 40 % of its stall torque. At a reversal with a degree
//! of play the shaft rests while the motor turns. How often intact drives reach a level stands in
//! `docs/health.md`. At a lower demand faults 9 and 10 report a jam.

use crate::{
    interface::Telemetry,
    timing::{CONTROL_PERIOD_MS, periods, thousandths},
};
use model_core::control::units::{Angle, Percent};

/// The recommended level, deg/s.
pub const LEVEL_DEG_S: u16 = 36;

/// Time without motion.
const LASTS: u16 = periods(72);

/// Travel of a shaft at rest, mdeg: two counts of the encoder.
const REST_MDEG: i32 = 176;

/// Travel of a motor at rest, in eighths of that of a control period at the least rate, 40 deg/s:
/// 0.5 deg, below the play that a motor takes up.
const MOTOR_EIGHTHS: i32 = 8 * 500 / (40 * CONTROL_PERIOD_MS);

/// The demand that is not met.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Jam {
    /// Where the shaft was when it began.
    from: Angle,
    /// The sum of the back-EMF since then, mV.
    turned_mv: i32,
    /// Control periods since then.
    periods: u16,
    /// Whether the demand is upward.
    is_upward: bool,
}

impl Jam {
    /// Takes a control period of an actuator that is driven, with its back-EMF, or 0 where a diode
    /// conducts; `level` is the least demand, deg/s. Returns whether the shaft is jammed.
    pub fn observe(&mut self, t: &Telemetry, back_emf_mv: i32, least_mv: i32, level: u16) -> bool {
        let demand_mdeg_s = thousandths(t.rate_command);
        let is_upward = demand_mdeg_s > 0;
        let drives_there = match is_upward {
            true => t.duty > Percent::ZERO,
            false => t.duty < Percent::ZERO,
        };
        self.turned_mv += back_emf_mv;
        let travel_mdeg = thousandths(t.angle - self.from);
        let is_at_rest =
            travel_mdeg.abs() <= REST_MDEG && self.turned_mv.abs() * 8 < least_mv * MOTOR_EIGHTHS;
        let is_demanded = demand_mdeg_s.abs() >= 1000 * i32::from(level)
            && drives_there
            && is_upward == self.is_upward;
        if !is_demanded || !is_at_rest {
            *self = Self {
                from: t.angle,
                is_upward,
                ..Self::default()
            };
        }
        self.periods = self.periods.saturating_add(1);
        self.periods > LASTS
    }
}
