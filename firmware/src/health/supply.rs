//! The resistance of the supply with its leads and contacts.
//!
//! Current and supply are sampled together in the middle of the on time, in which the bridge draws
//! the winding's current: `supply = open - R current`. The mean supply with a current, against that
//! without one, gives `R`. Neither is older than some seconds, so the slow discharge of a battery
//! cancels.
//! On times below a quarter do not count: the capacitor at the bridge (470 uF) then gives a part of
//! the current. What it gives later makes the result up to a quarter too low.

use super::statistics::{SHORTEST, Statistics};
use super::{FRACTION, Mean};
use crate::{interface::Telemetry, timing::periods};
use model_core::control::units::Percent;

/// Least duty of a load, and greatest of an idle bridge.
const LOADED_DUTY: Percent = Percent::from_int(25);
const IDLE_DUTY: Percent = Percent::from_int(5);

/// Least current of a load, mA.
const LEAST_MA: i32 = 100;

/// Control periods of a mean: 2 s.
const LENGTH: u16 = periods(2_048);

/// Control periods, each with and without a load, after which the resistance is known: 1 s.
const ENOUGH: u16 = periods(1_024);

/// Control periods without a value after which a mean is too old: 8 s.
const OLDEST: u16 = periods(8_192);

/// Means of supply and current.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Means {
    count: u16,
    /// Control periods since the last value.
    age: u16,
    supply: Mean,
    current: Mean,
}

impl Means {
    fn take(&mut self, supply_mv: i32, current_ma: i32) {
        if self.age > OLDEST {
            *self = Self::default();
        }
        self.age = 0;
        self.count = self.count.saturating_add(1).min(LENGTH);
        self.supply.take(supply_mv, self.count);
        self.current.take(current_ma, self.count);
    }
}

/// Sums of one load.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Load {
    is_positive: bool,
    /// Control periods, at most [`LENGTH`]; later ones are not in the sums.
    periods: u16,
    mv: i32,
    ma: i32,
}

impl Load {
    fn take(&mut self, supply_mv: i32, current_ma: i32) {
        if self.periods < LENGTH {
            self.periods += 1;
            // Measurements are below 2^16, and the sums below 2^27.
            self.mv += supply_mv;
            self.ma += current_ma;
        }
    }

    /// The resistance by this load, mohm, against the supply of an idle bridge.
    fn mohm(&self, idle: Mean) -> Option<i32> {
        let open = i64::from(idle.0) * i64::from(self.periods);
        let sag = open - (i64::from(self.mv) << FRACTION);
        // At least 100 mA in each control period: below 2^20.
        Some((sag * 1000).checked_div(i64::from(self.ma) << FRACTION)? as i32)
    }
}

/// The supply with and without a load.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Supply {
    /// The duty while the present measurements were sampled.
    duty: Percent,
    idle: Means,
    loaded: Means,
    /// The load since the last result.
    load: Load,
    /// The last result, mohm.
    resistance: Option<i32>,
    statistics: Statistics,
}

impl Supply {
    /// Takes the measurements of a control period.
    pub fn observe(&mut self, t: &Telemetry) {
        let duty = core::mem::replace(&mut self.duty, t.duty);
        let is_positive = duty > Percent::ZERO;
        let (duty, drawn_ma) = if duty < Percent::ZERO {
            (-duty, -t.sampled_ma)
        } else {
            (duty, t.sampled_ma)
        };
        for means in [&mut self.idle, &mut self.loaded] {
            means.age = means.age.saturating_add(1);
        }
        if duty >= LOADED_DUTY && drawn_ma >= LEAST_MA {
            self.loaded.take(t.supply_mv, drawn_ma);
            self.load.is_positive = is_positive;
            self.load.take(t.supply_mv, drawn_ma);
        } else if duty <= IDLE_DUTY {
            // What the winding still carries circulates in the bridge.
            self.idle.take(t.supply_mv, 0);
            if self.load.periods > 0
                && let Some(mohm) = self.measured()
            {
                self.resistance = Some(mohm);
                let load = core::mem::take(&mut self.load);
                if load.periods >= SHORTEST
                    && let Some(of_load) = load.mohm(self.idle.supply)
                {
                    (self.statistics).value(load.is_positive, of_load, load.periods);
                }
            }
        }
    }

    /// The resistance, mohm; `None` before there are enough values.
    pub fn resistance(&self) -> Option<i32> {
        self.resistance
    }

    /// Its standard error, mohm, without that of the supply of an idle bridge, which has more
    /// values.
    pub fn standard_error(&self) -> Option<i32> {
        self.statistics.standard_error(self.loaded.count)
    }

    /// That of the means, behind a load.
    fn measured(&self) -> Option<i32> {
        let Self { idle, loaded, .. } = self;
        if idle.count.min(loaded.count) < ENOUGH {
            return None;
        }
        let sag = i64::from(idle.supply.0) - i64::from(loaded.supply.0);
        let mohm = (sag * 1000).checked_div(loaded.current.0.into())?;
        // A supply that was raised meanwhile shows less than nothing.
        Some(i32::try_from(mohm).ok()?.max(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use model_core::control::units::percent;

    /// Takes a control period with this duty, %, and what is sampled in it.
    fn observe(supply: &mut Supply, duty_pct: i32, sampled_ma: i32, supply_mv: i32) {
        supply.duty = Percent::from_int(duty_pct);
        supply.observe(&Telemetry {
            sampled_ma,
            supply_mv,
            ..Telemetry::default()
        });
    }

    #[test]
    fn the_supply_under_load_against_that_without_is_the_resistance() {
        for sign in [1, -1] {
            let mut supply = Supply::default();
            for period in 0..=512 {
                // 0.2 ohm, and a battery that loses 100 mV meanwhile.
                let (duty_pct, current_ma) = if period % 2 == 0 { (0, 0) } else { (40, 500) };
                let supply_mv = 7_000 - period / 5 - current_ma / 5;
                observe(&mut supply, sign * duty_pct, sign * current_ma, supply_mv);
                // Behind the last of 256 with a load.
                assert_eq!(supply.resistance().is_some(), period == 512);
            }
            // A mean has steps of 2^-13 of its unit, times its length: 0.03 mV of 100.
            let found = supply.resistance().expect("256 values of both");
            assert!((found - 200).abs() <= 1, "{found}");
        }
    }

    #[test]
    fn a_battery_that_was_discharged_under_a_long_load_is_no_resistance() {
        let mut supply = Supply::default();
        let mut observe = |periods: u32, duty_pct, current_ma, open_mv: i32| {
            for _ in 0..periods {
                observe(&mut supply, duty_pct, current_ma, open_mv - current_ma / 5);
            }
            supply.resistance()
        };
        observe(1_000, 0, 0, 7_400);
        // Held for an hour, then moved.
        observe(900_000, 40, 500, 6_800);
        assert_eq!(observe(255, 0, 0, 6_800), None);
        let found = observe(1, 0, 0, 6_800).expect("256 values without a load");
        assert!((found - 200).abs() <= 1, "{found}");
        // At rest for an hour, with a full battery then.
        observe(900_000, 0, 0, 7_400);
        observe(256, 40, 500, 7_400);
        let found = observe(1, 0, 0, 7_400).expect("it stays");
        assert!((found - 200).abs() <= 1, "{found}");
    }

    #[test]
    fn currents_of_short_on_times_and_those_that_brake_are_no_load() {
        let mut supply = Supply::default();
        for (duty_pct, sampled_ma) in [(20, 500), (-40, 500), (40, 50)].repeat(600) {
            observe(&mut supply, duty_pct, sampled_ma, 5_000);
        }
        assert_eq!(supply.loaded.count, 0);
    }

    #[test]
    fn the_duty_of_a_sample_is_that_of_the_control_period_before() {
        let mut supply = Supply::default();
        supply.observe(&Telemetry {
            duty: percent(40.0),
            sampled_ma: 500,
            ..Telemetry::default()
        });
        assert_eq!((supply.loaded.count, supply.idle.count), (0, 1));
    }
}
