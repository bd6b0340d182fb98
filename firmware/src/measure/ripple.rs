//! From the current in the middle of the on time to its mean and its mean square.
//!
//! The winding's time constant `L/R` is shorter than a PWM period, so the current pulses. With slow
//! decay and a constant back-EMF `e` it is linear in the supply `V` and in `e`:
//!
//! ```text
//! i(t) = (V x(t) - e)/R
//! mean   = sample - V/R (x(sample) - duty)
//! square = mean^2 + (V/R)^2 (mean of x^2 - duty^2)
//! ```
//!
//! While the shaft stands, `e` is zero, and the mean is `sample duty/x(sample)` as well. The two
//! differ where `R` is not that of the parameters. With another number of turns `R` and `L` change
//! alike, and `x` does not: the second is right, and the first is 25 to 30 % too high at 70 %. With
//! the temperature `R` alone changes: from -20 to 105 deg C their errors are up to 7 %, in opposite
//! directions. Around 500 mA their average is within 3 % there, and 15 % too high at 70 % of both.
//!
//! `x(t)` is the periodic response of the winding to a voltage that is 1 in the on time and 0 in
//! the off time. Both factors depend on the duty and on the period over the time constant alone; a
//! table of them is computed when the motor's parameters change.
//!
//! The coast window in every last PWM period is not part of it. It takes at most 7.4 % from the
//! mean over a control period (stall at full duty).

use super::single::Single;
use model_core::{
    control::pwm_timer::{APERTURE_CYCLES, CurrentInstant, PWM_COUNTS, PwmCompare, TIMER_DIVIDER},
    time::PWM_RATE_HZ,
};

/// Steps of the table over the duty. At 1 kHz and 0.13 ms the second derivative of `x(sample)` by
/// the duty is at most (T/2 tau)^2 = 15: straight lines over 1/32 are within 15/8/32^2 = 0.2 %.
const STEPS: usize = if (PWM_COUNTS as usize).is_multiple_of(32) {
    32
} else {
    28
};
const _: () = assert!((PWM_COUNTS as usize).is_multiple_of(STEPS));

/// Counts of the compare value in a step.
const STEP_COUNTS: u32 = PWM_COUNTS as u32 / STEPS as u32;

/// Counts of the dead time: the on time begins so much after the edge.
const DEAD_COUNTS: f32 = 168.0 / TIMER_DIVIDER as f32;

/// The factors for one duty.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
struct Factors {
    /// `x(sample) - duty`.
    excess: Single,
    /// `mean of x^2 - duty^2`.
    variance: Single,
}

/// The current over a PWM period.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PeriodCurrent {
    /// The mean, which makes the torque, mA.
    pub mean_ma: i32,
    /// The mean at this duty and supply without a back-EMF, mA.
    pub stall_ma: i32,
    /// The mean if the shaft stands, mA: the average of both expressions, which depends less on the
    /// resistance than `mean_ma`.
    pub standing_ma: i32,
    /// The mean of the square, which heats the winding, mA^2; at most that of 46 A.
    pub square_ma2: i32,
}

/// The factors for all duties, for one winding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Ripple {
    table: [Factors; STEPS + 1],
    /// 1/R, 1/ohm.
    conductance: Single,
}

impl Ripple {
    /// The factors for a winding of this resistance, ohm, and inductance, H; both above 0.
    pub fn of(resistance_ohm: f32, inductance_h: f32) -> Self {
        // Periods in units of the time constant.
        let decay = resistance_ohm / (inductance_h * PWM_RATE_HZ as f32);
        let mut table = [Factors::default(); STEPS + 1];
        for (step, factors) in table.iter_mut().enumerate() {
            *factors = factors_at(step as u32 * STEP_COUNTS, decay);
        }
        Self {
            table,
            conductance: Single::new(1.0 / resistance_ohm),
        }
    }

    fn conductance(&self) -> f32 {
        self.conductance.get()
    }

    /// The current of a back-EMF alone, mA.
    pub fn of_back_emf_ma(&self, back_emf_mv: i32) -> i32 {
        (back_emf_mv as f32 * self.conductance()) as i32
    }

    /// Mean and mean square of the current that was sampled in a period with this compare value,
    /// with this supply during the on time.
    ///
    /// ```
    /// use firmware::measure::Ripple;
    /// use model_core::control::{pwm_timer::Modulator, units::percent};
    ///
    /// // 7.7 ohm, 1 mH: a stall at 20 % and 6 V reads 423 mA, and its mean is 155 mA.
    /// let compare = Modulator::default().next(percent(20.0));
    /// let current = Ripple::of(7.7, 1e-3).over_period(423, compare, 6000);
    /// assert!((current.mean_ma - 155).abs() <= 2);
    /// ```
    pub fn over_period(
        &self,
        sampled_ma: i32,
        compare: PwmCompare,
        supply_mv: i32,
    ) -> PeriodCurrent {
        let counts = compare.get().unsigned_abs();
        let step = (counts / STEP_COUNTS) as usize;
        let beyond = (counts % STEP_COUNTS) as f32 * (1.0 / STEP_COUNTS as f32);
        let at = |step: usize| self.table.get(step.min(STEPS)).copied().unwrap_or_default();
        let (low, high) = (at(step), at(step + 1));
        let excess = low.excess.get() + (high.excess.get() - low.excess.get()) * beyond;
        let variance = low.variance.get() + (high.variance.get() - low.variance.get()) * beyond;
        let full_ma = supply_mv as f32 * self.conductance();
        let signed_ma = if compare.get() < 0 { -full_ma } else { full_ma };
        let sampled_ma = sampled_ma as f32;
        let mean_ma = sampled_ma - signed_ma * excess;
        let duty = counts as f32 * (1.0 / PWM_COUNTS as f32);
        // Without a duty the current does not pulse.
        let share = if counts == 0 {
            1.0
        } else {
            duty / (duty + excess)
        };
        PeriodCurrent {
            // All saturate.
            mean_ma: mean_ma as i32,
            stall_ma: (signed_ma * duty) as i32,
            standing_ma: (0.5 * (mean_ma + sampled_ma * share)) as i32,
            square_ma2: (mean_ma * mean_ma + full_ma * full_ma * variance) as i32,
        }
    }
}

/// The factors for a compare value of so many counts, if `decay` is the period over the time
/// constant.
fn factors_at(counts: u32, decay: f32) -> Factors {
    let exp = |periods: f32| libm::expf(-decay * periods);
    let period = PWM_COUNTS as f32;
    let duty = if counts == PWM_COUNTS as u32 {
        1.0
    } else {
        ((counts as f32 - DEAD_COUNTS) / period).max(0.0)
    };
    let instant = CurrentInstant::of_on_time(counts).count() as f32;
    let aperture = APERTURE_CYCLES as f32 / TIMER_DIVIDER as f32;
    let dead = if duty == 1.0 { 0.0 } else { DEAD_COUNTS };
    // Since the start of the on time.
    let sample = (instant + aperture - dead) / period;
    // x at the start of a period and at the end of its on time.
    let (on, off) = (exp(duty), exp(1.0 - duty));
    let start = (1.0 - on) * off / (1.0 - on * off);
    let end = 1.0 - (1.0 - start) * on;
    let sampled = if sample <= duty {
        1.0 - (1.0 - start) * exp(sample)
    } else {
        end * exp(sample - duty)
    };
    let below = 1.0 - start;
    let square_on =
        duty - 2.0 * below * (1.0 - on) / decay + below * below * (1.0 - on * on) / (2.0 * decay);
    let square_off = end * end * (1.0 - off * off) / (2.0 * decay);
    let variance = (square_on + square_off - duty * duty).max(0.0);
    Factors {
        excess: Single::new(sampled - duty),
        variance: Single::new(variance),
    }
}

#[cfg(test)]
mod tests {
    use model_core::{
        control::{pwm_timer::Modulator, units::percent},
        plant::board::{BoardPlant, BoardPlantOptions, Bridge, Slot},
    };

    use super::*;
    use crate::measure::current_ma;

    /// A stalled plant in its fourth millisecond at this compare value: what the board samples, and
    /// mean and mean square of the current over the period, A. The winding has these shares of the
    /// model's resistance and inductance.
    fn stalled(compare: i32, (resistance, inductance): (f64, f64)) -> (i32, f64, f64) {
        let (ohm, henry) = (7.7 * resistance, 1e-3 * inductance);
        let mut options = BoardPlantOptions::default();
        options.drivetrain.electrical.winding_resistance_ohm = ohm;
        options.drivetrain.electrical.winding_inductance_h = henry;
        let mut plant = BoardPlant::try_new(&options).unwrap();
        plant.defects.is_jammed = true;
        let bridge = Bridge::driven(compare);
        let current = bridge.current_instant();
        let run =
            |plant: &mut BoardPlant| Slot::ALL.map(|slot| plant.advance(bridge, slot, current));
        for _ in 0..3 {
            run(&mut plant);
        }
        // Every microsecond of the fourth period in closed form, from a steady state.
        let (tau, full_a) = (henry / ohm, 6.0 / ohm * f64::from(compare.signum()));
        let on_s = match compare.abs() {
            56_000 => 1e-3,
            counts => f64::from(counts.max(56) - 56) / 56e6,
        };
        let (mut now_a, mut sum, mut square) = (0.0_f64, 0.0, 0.0);
        for step in 0..4000 {
            let at_s = f64::from(step % 1000) * 1e-6 + 0.5e-6;
            let target_a = if at_s < on_s { full_a } else { 0.0 };
            now_a = target_a + (now_a - target_a) * (-1e-6 / tau).exp();
            if step >= 3000 {
                sum += now_a / 1000.0;
                square += now_a * now_a / 1000.0;
            }
        }
        run(&mut plant);
        (current_ma(plant.sensed().current), sum, square)
    }

    #[test]
    fn mean_and_square_are_those_of_the_pulsing_current() {
        let ripple = Ripple::of(7.7, 1e-3);
        for pct in [0, 3, 10, -10, 20, 30, 50, -50, 80, 95, 100] {
            let compare = Modulator::default().next(percent(f64::from(pct)));
            let (sampled_ma, mean_a, square_a2) = stalled(compare.get(), (1.0, 1.0));
            let found = ripple.over_period(sampled_ma, compare, 6000);
            // Half a code of 1.6 mA, 0.2 % of 779 mA from the table, and 1 mA of rounding.
            let error_ma = (f64::from(found.mean_ma) - mean_a * 1e3).abs();
            assert!(error_ma < 3.4, "{pct} %: {found:?}, {mean_a} A");
            // The same error in the mean, at most 780 mA, and 0.2 % of 779 mA squared.
            let error = (f64::from(found.square_ma2) - square_a2 * 1e6).abs();
            let bound = 2.0 * mean_a.abs() * 1e3 * 3.4 + 0.002 * 779.0 * 779.0;
            assert!(error < bound, "{pct} %: {found:?}, {square_a2} A^2");
        }
    }

    /// Greatest error of `standing_ma` at mean currents of 450 to 550 mA, in shares of them.
    fn error_while_standing(winding: (f64, f64)) -> f64 {
        let ripple = Ripple::of(7.7, 1e-3);
        let errors = (-100..=100).filter_map(|pct| {
            let compare = Modulator::default().next(percent(f64::from(pct)));
            let (sampled_ma, mean_a, _) = stalled(compare.get(), winding);
            let found = ripple.over_period(sampled_ma, compare, 6000);
            let error = f64::from(found.standing_ma) / (mean_a * 1e3) - 1.0;
            (0.45..0.55).contains(&mean_a.abs()).then_some(error)
        });
        let greater = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
        errors.reduce(greater).expect("such currents")
    }

    #[test]
    fn a_standing_motor_has_its_mean_at_any_temperature_and_nearly_with_other_turns() {
        // The resolution as above, 3.4 of 450 mA, and 2 %.
        for copper_deg_c in [-20.0, 0.0, 25.0, 60.0, 105.0] {
            let error = error_while_standing((1.0 + 0.0039 * (copper_deg_c - 25.0), 1.0));
            assert!(error.abs() < 0.03, "{copper_deg_c} deg C: {error}");
        }
        // 70 % of the turns squared, where `mean_ma` is off by 30 %.
        let error = error_while_standing((0.7, 0.7));
        assert!((0.1..0.16).contains(&error), "{error}");
    }

    #[test]
    fn no_drive_leaves_the_sample_as_it_is() {
        let found = Ripple::of(7.7, 1e-3).over_period(-120, PwmCompare::default(), 6000);
        assert_eq!((found.mean_ma, found.square_ma2), (-120, 14_400));
        assert_eq!(found.standing_ma, -120);
    }

    #[test]
    fn the_ends_of_the_parameters_give_finite_factors() {
        for (ohm, henry) in [(0.05, 1.0), (1000.0, 1e-6), (0.05, 1e-6), (1000.0, 1.0)] {
            let ripple = Ripple::of(ohm, henry);
            let mut modulator = Modulator::default();
            for pct in -100..=100 {
                let compare = modulator.next(percent(f64::from(pct)));
                let found = ripple.over_period(2000, compare, 16_500);
                // The supply over the resistance, and the sample.
                let full_ma = f64::from(16_500.0 / ohm) + 2000.0;
                assert!(f64::from(found.mean_ma.abs()) <= full_ma * 1.001);
                assert!(f64::from(found.standing_ma.abs()) <= full_ma * 1.001);
            }
        }
    }
}
