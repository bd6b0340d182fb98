//! Motor current and encoder against what duty, supply and back-EMF make.
//!
//! ```text
//! expected mean current = (duty supply - back-EMF)/resistance
//! ```
//!
//! A dead current sense reads zero. A winding that is hot or that has brushes of high resistance
//! takes less than expected, but not less than a third: copper would have to be at 500 deg C. No
//! motor takes more than its resistance and its back-EMF permit, of which each may be off by 30 %:
//! a resistance of 70 % gives `1/0.7 - 1` = 43 % more of both currents, of which the expected one
//! is the difference.
//!
//! A motor that is connected the wrong way round turns against the loop, which drives it to its
//! full rate. Its back-EMF has the sign of the voltage, and the encoder turns the other way, by
//! more than the play of the gears.

use model_core::control::units::Rate;

use super::{Conditions, lasting::Lasting};
use crate::{
    faults::{Fault, FaultSet},
    measure::Ripple,
    parameters::EncoderLimits,
    timing::CONTROL_PERIOD_MS,
};

/// Control periods for which the current has to be wrong: 60 ms, a reversal at the full rate, in
/// which the back-EMF is hidden, and twice as much.
pub const CURRENT_IMPLAUSIBLE_PERIODS: i32 = 60 / CONTROL_PERIOD_MS;

/// Control periods for which the encoder has to turn against the back-EMF: 12 ms, before the
/// comparison of the travels finds the encoder implausible ([`super::travel`]).
pub const MOTOR_POLARITY_PERIODS: i32 = 12 / CONTROL_PERIOD_MS;

/// Expected current from which it is compared: a fifth of the stall current of 780 mA, and 45
/// times the error of half a code and the table of the ripple.
const COMPARED_MA: i32 = 150;

/// Rate of the encoder against the motor: half of that of `stuck_back_emf_mv`. In the play of the
/// gears a load turns the shaft slowly against a motor that takes it up.
const AGAINST: Rate = Rate::from_int(20);

/// For how long current and encoder have been implausible.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct PlausibilityGuard {
    current: Lasting,
    polarity: Lasting,
}

impl PlausibilityGuard {
    /// For how many control periods the current has been implausible.
    pub fn current_periods(&self) -> u16 {
        self.current.periods()
    }

    /// For how many control periods the encoder has turned against the motor.
    pub fn polarity_periods(&self) -> u16 {
        self.polarity.periods()
    }

    /// Which of them is implausible.
    pub fn check(
        &mut self,
        limits: &EncoderLimits,
        ripple: &Ripple,
        is_beyond_play: bool,
        c: &Conditions<'_>,
    ) -> FaultSet {
        let mut present = FaultSet::EMPTY;
        let is_implausible = is_implausible(ripple, c);
        present.put(
            Fault::CurrentImplausible,
            self.current.update(
                is_implausible,
                CURRENT_IMPLAUSIBLE_PERIODS * CONTROL_PERIOD_MS,
            ),
        );
        let is_reversed = turns_against_back_emf(limits, c);
        let lasts = (self.polarity).update(is_reversed, MOTOR_POLARITY_PERIODS * CONTROL_PERIOD_MS);
        present.put(Fault::MotorPolarity, lasts && is_beyond_play);
        present
    }
}

fn is_implausible(ripple: &Ripple, c: &Conditions<'_>) -> Option<bool> {
    let current = c.measured.current?;
    let back_emf_ma = ripple.of_back_emf_ma(c.measured.back_emf_mv?);
    let expected_ma = current.stall_ma - back_emf_ma;
    let is_compared = c.is_driving && expected_ma.abs() >= COMPARED_MA;
    // In its direction: the mean of a sample of zero is against it, as the current pulses.
    let mean_ma = current.mean_ma * expected_ma.signum();
    let is_small = is_compared && 3 * mean_ma < expected_ma.abs();
    // Both below 2^19 mA.
    let parts_ma = current.stall_ma.abs() + back_emf_ma.abs();
    let beyond_ma = (current.mean_ma - expected_ma).abs() - COMPARED_MA;
    let is_large = c.is_driving && beyond_ma > parts_ma * 43 / 100;
    // A motor that takes little current shows nothing while it is driven.
    let is_known = is_compared || is_large || !c.is_driving;
    is_known.then_some(is_small || is_large)
}

fn turns_against_back_emf(limits: &EncoderLimits, c: &Conditions<'_>) -> Option<bool> {
    let travelled = c.measured.travelled?;
    let back_emf_mv = c.measured.back_emf_mv?;
    let is_moving = travelled != 0 && back_emf_mv.abs() >= limits.stuck_back_emf_mv;
    let is_against = match back_emf_mv > 0 {
        true => c.rate < -AGAINST,
        false => c.rate > AGAINST,
    };
    Some(c.is_driving && is_moving && is_against)
}
