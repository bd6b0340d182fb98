//! A brake that needs no encoder: the duty opposes the back-EMF.
//!
//! With the supply `V`, the resistance `R` and the back-EMF `e` the mean current is
//!
//! ```text
//! duty = -k e/V
//! i    = (duty V - e)/R = -(1 + k) e/R
//! ```
//!
//! so the torque is `1 + k = 5` times that of the shorted motor. A shaft that turns decelerates
//! with the mechanical time constant over `1 + k`, 0.132 s/5 = 26 ms, and a load lowers at a fifth
//! of the rate: 0.8 N m at 53 deg/s, where it turns the shorted motor at 265 deg/s. The duty is in
//! force from 1 to 5 ms after the back-EMF was measured: on average 3 ms, a phase of 4 x 3/132 rad
//! at the crossover.
//!
//! The duty stays below [`GREATEST_PCT`]: the winding's current, L/R = 0.13 ms, then decays to that
//! of the shorted motor before the window in which the back-EMF is measured, where a larger one
//! would hide it.
//!
//! The brake trusts the back-EMF, and would drive the shaft with one that is wrong. Until its sign
//! was that of `duty V - i R`, by the measured current, in periods with enough of both, the motor
//! is shorted instead: exchanged dividers. A shorted motor that a load turns shows the sign as
//! well: `-i R` is its back-EMF. That counts once the motor was driven, so that a board which was
//! never commanded to drive gives no duty. It is shorted too once the encoder shows a motion in the
//! direction of the duty while less than half of the expected current flows, for 20 ms: a leg whose
//! voltage is wrong.

use model_core::control::units::{Percent, Rate};

use crate::{
    measure::{PeriodCurrent, Ripple},
    parameters::CurrentLimits,
};

/// `k`.
pub(super) const OPPOSING: i32 = 4;

/// Greatest duty, %: its on time ends 50 us before the window, which begins after 80 % of the last
/// PWM period.
const GREATEST_PCT: i32 = 75;

/// The shaft stands below this back-EMF: 5 deg/s at 20 mV per deg/s.
const STANDING_MV: i32 = 100;

/// The sign of the back-EMF counts from here: 30 deg/s.
const COUNTED_MV: i32 = 600;

/// Likewise of `duty V - i R` over the resistance, beyond a third of the current, by which the
/// resistance may be wrong: 15 times half a code, and two thirds of the current of a shorted motor
/// at 30 deg/s.
const COUNTED_MA: i32 = 50;

/// The same at a small duty, `duty V/R` below [`SLOW_MA`], as in a homing: from 20 deg/s, 52 mA.
/// Errors of resistance and ripple are in proportion to the duty: 30 % of the resistance are 23 mA.
/// With 20 mA of offset of the current, 10 mA of the legs' dividers, and 22 mA, by which the
/// back-EMF changes between its sample and that of the current, a wrong sign needs 77 mA, and all
/// errors at once are 75 mA.
const SLOW_MV: i32 = 400;
const SLOW_COUNTED_MA: i32 = 25;
const SLOW_MA: i32 = 100;

/// Scans, 12 ms, after which the sign is known.
const KNOWN: i8 = 3;

/// A motion against the brake counts from this rate on, for 20 ms.
const CONTRADICTING: Rate = Rate::from_int(10);
const CONTRADICTED: u8 = 5;

/// Whether the shaft stands, by its back-EMF.
pub(super) const fn stands(back_emf_mv: i32) -> bool {
    back_emf_mv.abs() < STANDING_MV
}

/// The duty whose mean voltage is this one, in steps of 2^-8 %, limited to 100 %.
pub(super) fn duty_of(mean_mv: i32, supply_mv: i32) -> Percent {
    // The legs are measured up to 16.5 V: 4 * 16,500 * 100 * 256 < 2^31.
    let steps = mean_mv * UNITS / supply_mv.max(1);
    duty_of_units(steps.clamp(-UNITS, UNITS))
}

/// 100 % in units of [`duty_of`].
pub(super) const UNITS: i32 = 100 << 8;

/// Duty in units of [`duty_of`], 2^-8 %.
pub(super) fn units_of(duty: Percent) -> i32 {
    (duty.to_bits() >> 24) as i32
}

/// The duty of so many units.
pub(super) fn duty_of_units(units: i32) -> Percent {
    Percent::from_bits(i64::from(units) << 24)
}

/// What is known of the back-EMF.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct BackEmfBrake {
    /// Periods in which its sign was right, less those in which it was wrong, up to [`KNOWN`].
    agreed: i8,
    /// Periods in which the shaft turned with the duty of the brake.
    contradicted: u8,
    /// The motor was driven, and the brake has not been contradicted since.
    was_driven: bool,
}

impl BackEmfBrake {
    /// Takes the back-EMF and the current of a motor that is driven.
    pub fn observe_driven(&mut self, current: PeriodCurrent, back_emf_mv: i32) {
        self.was_driven = true;
        self.observe(current, back_emf_mv);
    }

    /// Takes the back-EMF and the current of a motor that is braked.
    pub fn observe_braked(&mut self, current: PeriodCurrent, back_emf_mv: i32) {
        if self.was_driven {
            self.observe(current, back_emf_mv);
        }
    }

    fn observe(&mut self, current: PeriodCurrent, back_emf_mv: i32) {
        // Wires do not change: what is known stays known whatever the current sense shows later.
        if self.agreed == KNOWN {
            return;
        }
        let expected_ma = current.stall_ma - current.mean_ma;
        let (from_mv, from_ma) = if current.stall_ma.abs() < SLOW_MA {
            (SLOW_MV, SLOW_COUNTED_MA)
        } else {
            (COUNTED_MV, COUNTED_MA)
        };
        let counts = back_emf_mv.abs() >= from_mv
            && expected_ma.abs() >= from_ma + current.mean_ma.abs() / 3;
        if counts {
            let agrees = (expected_ma > 0) == (back_emf_mv > 0);
            let agreed = self.agreed + if agrees { 1 } else { -1 };
            self.agreed = agreed.clamp(-KNOWN, KNOWN);
        }
    }

    /// Takes what the brake has caused: the duty, the encoder's rate and the current, over which
    /// `expected_ma` is that of this duty and back-EMF.
    pub fn verify(&mut self, duty: Percent, rate: Rate, current: PeriodCurrent, expected_ma: i32) {
        let turns_on = duty > Percent::ZERO && rate > CONTRADICTING
            || duty < Percent::ZERO && rate < -CONTRADICTING;
        let contradicts = turns_on && 2 * current.mean_ma.abs() < expected_ma.abs();
        self.contradicted = if contradicts {
            self.contradicted + 1
        } else {
            0
        };
        if self.contradicted >= CONTRADICTED {
            *self = Self::default();
        }
    }

    /// The duty that opposes this back-EMF at this supply; zero, which shorts the motor, where the
    /// shaft stands, the sign is not known, or the current of the on time would be too large.
    pub fn opposing(
        self,
        limits: &CurrentLimits,
        ripple: &Ripple,
        (back_emf_mv, supply_mv): (i32, i32),
    ) -> Percent {
        // In the on time the current reaches (V + |e|)/R. Above the limit the bridge would trip,
        // and the shaft would coast: 5 % are left for the error of supply and resistance.
        let peak_ma = ripple.of_back_emf_ma(supply_mv + back_emf_mv.abs());
        let is_too_large = peak_ma > limits.over_current_ma - limits.over_current_ma / 20;
        if stands(back_emf_mv) || self.agreed != KNOWN || is_too_large {
            return Percent::ZERO;
        }
        duty_of(-OPPOSING * back_emf_mv, supply_mv).limited(Percent::from_int(GREATEST_PCT))
    }
}

#[cfg(test)]
mod tests {
    use model_core::control::units::percent;

    use super::*;

    /// The brake of a motor of 7.7 ohm that was driven with a back-EMF of this sign.
    fn duty(sign: i32, (back_emf_mv, supply_mv): (i32, i32)) -> Percent {
        let mut brake = BackEmfBrake::default();
        for _ in 0..3 {
            brake.observe_driven(current(500, 300), 600 * sign);
        }
        // Neither a small back-EMF nor a current that leaves it open counts.
        for _ in 0..10 {
            brake.observe_driven(current(-500, -300), 599 * sign);
            brake.observe_driven(current(-500, -670), 600 * sign);
            brake.observe_driven(current(-99, -30), 399 * sign);
            brake.observe_driven(current(-99, -75), 400 * sign);
        }
        let voltages = (back_emf_mv, supply_mv);
        brake.opposing(&CurrentLimits::DEFAULT, &Ripple::of(7.7, 1e-3), voltages)
    }

    fn current(stall_ma: i32, mean_ma: i32) -> PeriodCurrent {
        PeriodCurrent {
            mean_ma,
            stall_ma,
            ..PeriodCurrent::default()
        }
    }

    #[test]
    fn a_brake_that_turns_the_shaft_without_its_current_shorts_the_motor() {
        let known = BackEmfBrake {
            agreed: KNOWN,
            contradicted: 0,
            was_driven: true,
        };
        let after = |rate_deg_s, mean_ma, periods| {
            let mut brake = known;
            for _ in 0..periods {
                let rate = Rate::from_int(rate_deg_s);
                brake.verify(percent(-75.0), rate, current(-580, mean_ma), -960);
            }
            brake.opposing(
                &CurrentLimits::DEFAULT,
                &Ripple::of(7.7, 1e-3),
                (2900, 6000),
            )
        };
        assert_eq!(after(-50, -300, 4), percent(-75.0));
        assert_eq!(after(-50, -300, 5), Percent::ZERO);
        // A load that is braked, and an encoder that drifts.
        assert_eq!(after(50, -300, 100), percent(-75.0));
        assert_eq!(after(-50, -700, 100), percent(-75.0));
    }

    #[test]
    fn the_duty_is_four_times_the_share_of_the_back_emf_and_opposes_it() {
        for (back_emf_mv, duty_pct) in [(900, -60.0), (-300, 20.0), (99, 0.0), (4000, -75.0)] {
            assert_eq!(duty(1, (back_emf_mv, 6000)), percent(duty_pct));
        }
    }

    #[test]
    fn a_current_sense_that_is_wrong_later_does_not_change_what_is_known() {
        let mut brake = BackEmfBrake::default();
        for _ in 0..3 {
            brake.observe_driven(current(500, 300), 800);
        }
        for _ in 0..10 {
            brake.observe_driven(current(500, 900), 800);
        }
        let ripple = Ripple::of(7.7, 1e-3);
        let duty = brake.opposing(&CurrentLimits::DEFAULT, &ripple, (900, 6000));
        assert_eq!(duty, percent(-60.0));
    }

    #[test]
    fn a_slow_motion_shows_the_sign_of_the_back_emf() {
        let mut brake = BackEmfBrake::default();
        let ripple = Ripple::of(7.7, 1e-3);
        for _ in 0..3 {
            let duty = brake.opposing(&CurrentLimits::DEFAULT, &ripple, (900, 6000));
            assert_eq!(duty, Percent::ZERO);
            // 25 deg/s with a friction of 27 mA.
            brake.observe_driven(current(92, 27), 500);
        }
        let duty = brake.opposing(&CurrentLimits::DEFAULT, &ripple, (900, 6000));
        assert_eq!(duty, percent(-60.0));
    }

    #[test]
    fn a_load_that_turns_the_shorted_motor_shows_the_sign_of_the_back_emf() {
        let duty_after = |mean_ma, back_emf_mv, was_driven| {
            let mut brake = BackEmfBrake::default();
            if was_driven {
                brake.observe_driven(current(0, 0), 0);
            }
            for _ in 0..3 {
                brake.observe_braked(current(0, mean_ma), back_emf_mv);
            }
            let ripple = Ripple::of(7.7, 1e-3);
            brake.opposing(&CurrentLimits::DEFAULT, &ripple, (back_emf_mv, 6000))
        };
        // 30 deg/s: 600 mV are 78 mA, against the motion.
        assert_eq!(duty_after(-78, 600, true), percent(-40.0));
        assert_eq!(duty_after(78, -600, true), percent(40.0));
        // Exchanged dividers, a current sense that shows nothing, and a board without a command.
        assert_eq!(duty_after(78, 600, true), Percent::ZERO);
        assert_eq!(duty_after(0, 600, true), Percent::ZERO);
        assert_eq!(duty_after(-78, 600, false), Percent::ZERO);
    }

    #[test]
    fn the_motor_is_shorted_until_it_was_driven_with_a_back_emf_of_the_right_sign() {
        for sign in [-1, 0] {
            assert_eq!(duty(sign, (900, 6000)), Percent::ZERO);
        }
    }

    #[test]
    fn the_motor_is_shorted_where_the_current_of_the_on_time_would_be_too_large() {
        // (7.6 V + e)/7.7 ohm is 95 % of 2 A, 1900 mA, at e = 7.03 V, and a mA more at 7.038 V.
        assert!(duty(1, (7030, 7600)) < Percent::ZERO);
        assert_eq!(duty(1, (7038, 7600)), Percent::ZERO);
        assert_eq!(duty(1, (-7038, 7600)), Percent::ZERO);
    }

    #[test]
    fn no_measurement_gives_a_duty_beyond_its_range() {
        for back_emf_mv in [-16_500, -1, 0, 1, 16_500] {
            for supply_mv in [-20, 0, 1, 6000, 16_500] {
                assert!(duty(1, (back_emf_mv, supply_mv)).abs() <= percent(75.0));
            }
        }
    }
}
