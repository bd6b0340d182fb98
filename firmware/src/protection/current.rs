//! Motor current: too much at once, and too much for too long.
//!
//! ```text
//! heat = max(0, heat + mean of current^2 - continuous^2)   every control period T
//! Overload while heat >= 3 continuous^2 overload_ms/T
//! ```
//!
//! Twice the continuous current has four times its heat, three times it above what is carried
//! away: it reaches the limit after `overload_ms`. A missing sample leaves the heat as it is.
//!
//! The over-current is that of the sample in the on time, which is nearest to the peak. The heat
//! takes the mean square over the PWM period: the current pulses.

use super::{Conditions, lasting::Lasting};
use crate::{
    faults::{Fault, FaultSet},
    parameters::CurrentLimits,
    timing::{CONTROL_PERIOD_MS, periods},
};

/// Heat above what the motor carries away, mA^2 times control periods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct CurrentGuard {
    over: Lasting,
    heat: i64,
}

impl CurrentGuard {
    /// What is wrong with the current.
    pub fn check(&mut self, limits: &CurrentLimits, c: &Conditions<'_>) -> FaultSet {
        let sampled_ma = c.measured.sampled_ma.map(i32::abs);
        let is_over = sampled_ma.map(|sampled_ma| sampled_ma > limits.over_current_ma);
        let square_ma2 = c.measured.current.map(|current| current.square_ma2);
        // 1 to 25.
        let time_ms = limits.over_current_samples * CONTROL_PERIOD_MS;
        let mut present = FaultSet::EMPTY;
        present.put(Fault::OverCurrent, self.over.update(is_over, time_ms));
        present.put(Fault::Overload, self.is_overloaded(limits, square_ma2));
        present
    }

    fn is_overloaded(&mut self, limits: &CurrentLimits, square_ma2: Option<i32>) -> bool {
        // Squares are below 2^31. The continuous current is below 2^12 mA, and 60 s are at most
        // 30,000 < 2^15 periods: the limit is below 3 * 2^39, and the heat ends at twice that, so
        // that it also cools in time.
        let continuous = i64::from(limits.continuous_ma * limits.continuous_ma);
        let limit = 3 * continuous * i64::from(periods(limits.overload_ms));
        if let Some(square_ma2) = square_ma2 {
            let heated = self.heat + i64::from(square_ma2) - continuous;
            self.heat = if heated < 0 {
                0
            } else if heated > 2 * limit {
                2 * limit
            } else {
                heated
            };
        }
        self.heat >= limit
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        measure::PeriodCurrent,
        protection::{
            Measured,
            tests::{UNMEASURED, driven, smooth},
        },
    };

    /// A heat of 3 500^2 mA^2 for five periods is the limit.
    const LIMITS: CurrentLimits = CurrentLimits {
        continuous_ma: 500,
        overload_ms: 5 * CONTROL_PERIOD_MS,
        ..CurrentLimits::DEFAULT
    };

    /// Whether an overload is present in the last of so many control periods with this current.
    fn is_overloaded(guard: &mut CurrentGuard, current: PeriodCurrent, count: u32) -> bool {
        let measured = Measured {
            current: Some(current),
            ..UNMEASURED
        };
        let mut present = FaultSet::EMPTY;
        for _ in 0..count {
            present = guard.check(&LIMITS, &driven(&measured));
        }
        present.contains(Fault::Overload)
    }

    fn current(mean_ma: i32, square_ma2: i32) -> PeriodCurrent {
        PeriodCurrent {
            mean_ma,
            stall_ma: mean_ma,
            square_ma2,
        }
    }

    #[test]
    fn the_mean_square_heats_and_the_mean_does_not() {
        // Four times 500^2: three times that is above what is carried away, for five periods.
        let after = |current, count| is_overloaded(&mut CurrentGuard::default(), current, count);
        assert!(!after(current(400, 1_000_000), 4));
        assert!(after(current(400, 1_000_000), 5));
        assert!(!after(current(900, 250_000), 10_000));
    }

    #[test]
    fn an_overload_of_any_length_cools_in_the_time_from_twice_the_limit() {
        for count in [10, 11, 1000] {
            let mut guard = CurrentGuard::default();
            assert!(is_overloaded(&mut guard, current(1000, 1_000_000), count));
            // Without a current, 500^2 a period: the limit of 15 of them is reached after 15.
            assert!(is_overloaded(&mut guard, current(0, 0), 15));
            assert!(!is_overloaded(&mut guard, current(0, 0), 1));
        }
    }

    #[test]
    fn an_over_current_is_above_its_limit_in_either_direction_for_its_samples() {
        let limits = CurrentLimits {
            over_current_ma: 1600,
            over_current_samples: 2,
            ..CurrentLimits::DEFAULT
        };
        for (sampled_ma, is_over) in [(1600, false), (1601, true), (-1600, false), (-1601, true)] {
            let measured = Measured {
                sampled_ma: Some(sampled_ma),
                current: smooth(0),
                ..UNMEASURED
            };
            let mut guard = CurrentGuard::default();
            let mut check = || guard.check(&limits, &driven(&measured));
            assert!(!check().contains(Fault::OverCurrent));
            assert_eq!(
                check().contains(Fault::OverCurrent),
                is_over,
                "{sampled_ma}"
            );
        }
    }
}
