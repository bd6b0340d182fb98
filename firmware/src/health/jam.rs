//! A shaft that is jammed: the loop demands a rate and drives towards it, and neither shaft nor
//! motor turns.
//!
//! | of an intact drive | |
//! |---|---|
//! | a held load | the demand is the error times the gain: at 34 deg/s and 8/s, 4.25 deg off, a load turns that is below 40 % of the stall torque |
//! | play of a degree, at a reversal | the motor turns by it, and the shaft does not |
//! | gusts up to 0.3 of the stall torque | in 230 h of motors 30 % off at most 25.5 deg/s (`tests/detection`) |
//!
//! Faults 9 and 10 find the slow ones, which demand less.

use crate::{
    interface::Telemetry,
    timing::{CONTROL_PERIOD_MS, periods, thousandths},
};
use model_core::control::units::{Angle, Percent};

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
    /// Takes a control period of an actuator that is driven; `level` is the least demand, deg/s.
    /// Returns whether the shaft is jammed.
    pub fn observe(&mut self, t: &Telemetry, least_mv: i32, level: u16) -> bool {
        let demand_mdeg_s = thousandths(t.rate_command);
        let is_upward = demand_mdeg_s > 0;
        self.turned_mv += t.back_emf_mv;
        let travel_mdeg = thousandths(t.angle - self.from);
        let is_at_rest =
            travel_mdeg.abs() <= REST_MDEG && self.turned_mv.abs() * 8 < least_mv * MOTOR_EIGHTHS;
        let is_demanded = demand_mdeg_s.abs() >= 1000 * i32::from(level)
            && (t.duty > Percent::ZERO) == is_upward
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
