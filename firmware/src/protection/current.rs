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
    use model_core::control::units::{Angle, Percent, Rate};

    use super::*;
    use crate::{measure::PeriodCurrent, protection::Measured};

    /// Whether an overload of these currents is present after so many control periods.
    fn is_overloaded(mean_ma: i32, square_ma2: i32, count: u32) -> bool {
        let measured = Measured {
            count: None,
            travelled: None,
            magnet: None,
            sampled_ma: Some(mean_ma),
            current: Some(PeriodCurrent {
                mean_ma,
                stall_ma: mean_ma,
                square_ma2,
            }),
            back_emf_mv: None,
            supply_mv: None,
            temperature_mdeg_c: None,
        };
        let conditions = Conditions {
            measured: &measured,
            is_driving: true,
            is_following: true,
            angle: Angle::ZERO,
            rate: Rate::ZERO,
            setpoint: Angle::ZERO.into(),
            rate_command: Rate::ZERO,
            duty: Percent::ZERO,
            is_stale: false,
            is_bus_lost: false,
            is_tripped: false,
            missed_periods: 0,
        };
        let limits = CurrentLimits {
            continuous_ma: 500,
            overload_ms: 5 * CONTROL_PERIOD_MS,
            ..CurrentLimits::DEFAULT
        };
        let mut guard = CurrentGuard::default();
        let mut present = FaultSet::EMPTY;
        for _ in 0..count {
            present = guard.check(&limits, &conditions);
        }
        present.contains(Fault::Overload)
    }

    #[test]
    fn the_mean_square_heats_and_the_mean_does_not() {
        // Four times 500^2: three times that is above what is carried away, for five periods.
        assert!(!is_overloaded(400, 1_000_000, 4));
        assert!(is_overloaded(400, 1_000_000, 5));
        assert!(!is_overloaded(900, 250_000, 10_000));
    }
}
