//! Motor current and encoder against what duty, supply and back-EMF make.
//!
//! ```text
//! expected mean current = (duty supply - back-EMF)/resistance
//! expected sample = expected mean current + pulse
//! ```
//!
//! The current pulses ([`Ripple`]): the sample in the on time is larger than the mean by a part of
//! `supply/resistance`, however little current the motor takes. A dead current sense reads zero
//! where 27 mA of friction in slow motion, at a duty of 7 %, are a sample of 165 mA. A winding that
//! is hot or that has brushes of high resistance takes less than expected, but not less than a
//! third: copper would have to be at 500 deg C.
//!
//! No motor takes more than its resistance and its back-EMF permit, of which each may be off by
//! 30 %: a resistance of 70 % gives `1/0.7 - 1` = 43 %, at most 7/16, more of both currents, of
//! which the expected one is the difference.
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

/// Expected sample from which a small one is compared. A winding of 120 deg C with 130 % of the
/// resistance takes `1/(1.3 x 1.37)` = 56 % of the expected current, and with 130 % of the
/// inductance its pulse is at least 64 %: less 10 mA of offset of the amplifier, 46 mA are left,
/// and a third is 33 mA.
const LEAST_SAMPLE_MA: i32 = 100;

/// A pulse against the mean has to be so many times as large. A resistance of 70 % gives 143 % of
/// the mean, and with 130 % of the inductance at least 62 % of the pulse: of the mean
/// `6 x 0.62 - 1.43` = 2.29 are left, and a third of the expected sample is `(6 - 1)/3` = 1.67. For
/// 100 mA that is a margin of 12 mA, and the offset of the amplifier is 10 mA.
const PULSE_OVER_MEAN: i32 = 6;

/// Error of the expected mean current, a fifth of the stall current of 780 mA: in a reversal the
/// back-EMF changes between its sample and that of the current.
const MEAN_ERROR_MA: i32 = 150;

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
    let (current, sampled_ma) = (c.measured.current?, c.measured.sampled_ma?);
    let back_emf_ma = ripple.of_back_emf_ma(c.measured.back_emf_mv?);
    // The currents of supply and back-EMF are below 2^19 mA, the sums below 2^20: no product
    // overflows.
    let expected_ma = current.stall_ma - back_emf_ma;
    let pulse_ma = sampled_ma - current.mean_ma;
    let expected_sample_ma = expected_ma + pulse_ma;
    // A brake's mean current is against its pulse.
    let is_certain = pulse_ma == 0
        || (pulse_ma < 0) == (expected_ma < 0)
        || pulse_ma.abs() >= PULSE_OVER_MEAN * expected_ma.abs();
    let is_compared = c.is_driving && is_certain && expected_sample_ma.abs() >= LEAST_SAMPLE_MA;
    let is_small = is_compared && is_below_a_third(sampled_ma, expected_sample_ma);
    let parts_ma = current.stall_ma.abs() + back_emf_ma.abs();
    let beyond_ma = (current.mean_ma - expected_ma).abs() - MEAN_ERROR_MA;
    let is_large = c.is_driving && beyond_ma > parts_ma * 7 / 16;
    // A motor that takes little current shows nothing while it is driven.
    let is_known = is_compared || is_large || !c.is_driving;
    is_known.then_some(is_small || is_large)
}

/// Whether a value is below a third of another one, in its direction.
fn is_below_a_third(value: i32, whole: i32) -> bool {
    if whole < 0 {
        3 * value > whole
    } else {
        3 * value < whole
    }
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
