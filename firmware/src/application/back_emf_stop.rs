//! A stop that needs no encoder: the duty opposes the back-EMF.
//!
//! With the supply `V`, the resistance `R` and the back-EMF `e` the mean current is
//!
//! ```text
//! duty = -k e/V
//! i    = (duty V - e)/R = -(1 + k) e/R
//! ```
//!
//! so the torque is `1 + k` times that of the shorted motor, and the shaft decelerates with the
//! mechanical time constant over `1 + k`: 0.132 s/1.75 = 75 ms. As `k` is below 1, the shaft
//! decelerates even if the sign of the measured back-EMF is wrong: `i = -(1 - k) e/R`. A limit of
//! the duty makes `k` smaller, down to the shorted motor.
//!
//! The shaft stands while the back-EMF is below 100 mV, 5 deg/s. A stop that continues a ramp ends
//! within the time of the whole stop.

use model_core::control::units::Percent;

use super::stop_progress::StopProgress;
use crate::{
    measure::Ripple,
    parameters::{CurrentLimits, StopSettings},
};

/// `k` in percent.
const OPPOSING_PCT: i32 = 75;

/// The shaft stands below this back-EMF: 5 deg/s at 20 mV per deg/s.
const STANDING_MV: i32 = 100;

/// The state of such a stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct BackEmfStop {
    progress: StopProgress,
}

/// What the stop is computed from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Voltages {
    /// Unknown while a diode carries the winding's current.
    pub back_emf_mv: Option<i32>,
    pub supply_mv: i32,
}

impl BackEmfStop {
    /// A stop that continues another one.
    pub fn after(progress: StopProgress) -> Self {
        Self {
            progress: progress.continued(),
        }
    }

    /// The duty of this period; zero, which shorts the motor, without a back-EMF.
    pub fn next(&mut self, limits: &CurrentLimits, ripple: &Ripple, voltages: Voltages) -> Percent {
        let stands = voltages.back_emf_mv.map(|mv| mv.abs() < STANDING_MV);
        self.progress.next(stands);
        let Some(back_emf_mv) = voltages.back_emf_mv else {
            return Percent::ZERO;
        };
        // In the on time the current reaches (V + |e|)/R. Above the limit the bridge would trip,
        // and the shaft would coast: 5 % are left for the error of supply and resistance.
        let peak_ma = ripple.of_back_emf_ma(voltages.supply_mv + back_emf_mv.abs());
        if peak_ma > limits.over_current_ma - limits.over_current_ma / 20 {
            return Percent::ZERO;
        }
        opposing(back_emf_mv, voltages.supply_mv)
    }

    /// Whether it has ended.
    pub fn is_over(&self, settings: &StopSettings) -> bool {
        self.progress.is_over(settings)
    }
}

/// The duty `-k e/V`, in steps of 2^-8 %.
fn opposing(back_emf_mv: i32, supply_mv: i32) -> Percent {
    // Legs and supply are measured up to 16.5 V: 16,500 * 75 * 256 < 2^29.
    let steps = -(back_emf_mv * (OPPOSING_PCT << 8)) / supply_mv.max(1);
    let full = 100 << 8;
    Percent::from_bits(i64::from(steps.max(-full).min(full)) << 24)
}

#[cfg(test)]
mod tests {
    use model_core::control::units::percent;

    use super::*;

    /// A winding of 7.7 ohm.
    fn ripple() -> Ripple {
        Ripple::of(7.7, 1e-3)
    }

    fn next(stop: &mut BackEmfStop, back_emf_mv: Option<i32>, supply_mv: i32) -> Percent {
        let voltages = Voltages {
            back_emf_mv,
            supply_mv,
        };
        stop.next(&CurrentLimits::DEFAULT, &ripple(), voltages)
    }

    #[test]
    fn the_duty_is_three_quarters_of_the_share_of_the_back_emf_and_opposes_it() {
        for (back_emf_mv, duty_pct) in [(4000, -50.0), (-2000, 25.0), (0, 0.0), (80, -1.0)] {
            let duty = next(&mut BackEmfStop::default(), Some(back_emf_mv), 6000);
            assert_eq!(duty, percent(duty_pct));
        }
    }

    #[test]
    fn the_motor_is_shorted_where_the_current_of_the_on_time_would_be_too_large() {
        // (6 V + e)/7.7 ohm is 95 % of 1.6 A, 1520 mA, at e = 5.704 V, and a mA more at 5.712 V.
        let duty = |mv| next(&mut BackEmfStop::default(), Some(mv), 6000);
        assert!(duty(5704) < Percent::ZERO);
        assert_eq!(duty(5712), Percent::ZERO);
        assert_eq!(duty(-5712), Percent::ZERO);
    }

    #[test]
    fn no_measurement_gives_a_duty_beyond_its_range() {
        let limits = CurrentLimits {
            over_current_ma: i32::MAX,
            ..CurrentLimits::DEFAULT
        };
        for back_emf_mv in [-16_500, -1, 0, 1, 16_500] {
            for supply_mv in [-20, 0, 1, 6000, 16_500] {
                let voltages = Voltages {
                    back_emf_mv: Some(back_emf_mv),
                    supply_mv,
                };
                let duty = BackEmfStop::default().next(&limits, &ripple(), voltages);
                assert!(duty.abs() <= percent(100.0), "{voltages:?}");
            }
        }
    }

    #[test]
    fn it_ends_20_ms_after_the_shaft_stands_or_after_the_longest_time() {
        let settings = StopSettings::DEFAULT;
        let periods = |back_emf_mv: Option<i32>| {
            let mut stop = BackEmfStop::default();
            let mut periods = 0;
            while !stop.is_over(&settings) {
                next(&mut stop, back_emf_mv, 6000);
                periods += 1;
            }
            periods
        };
        assert_eq!(periods(Some(99)), 5);
        assert_eq!(periods(Some(-100)), 125);
        assert_eq!(periods(None), 125);
    }
}
