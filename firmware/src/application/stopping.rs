//! The ramp that brings the shaft to rest.
//!
//! The commanded rate starts at the measured one and falls by `quick_stop_deceleration_deg_s2` per
//! second. The stop ends once the command is zero and the shaft has stood for 20 ms, or when
//! `quick_stop_ms` has elapsed.

use model_core::control::units::{Angle, Rate};

use crate::{
    parameters::StopSettings,
    timing::{periods, rate_per_period},
};

/// The shaft stands below this rate: a quarter of one encoder count in 4 ms.
const STANDING: Rate = Rate::from_int(5);

/// Control periods for which it has to: 20 ms.
const STANDING_PERIODS: u8 = periods(20) as u8;

/// The state of a quick stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Stopping {
    command: Rate,
    periods: u16,
    standing: u8,
    held: Option<Angle>,
}

impl Stopping {
    /// A stop from this rate.
    pub fn from(rate: Rate) -> Self {
        Self {
            command: rate,
            ..Self::default()
        }
    }

    /// The commanded rate of this period, while the shaft turns at `rate`.
    pub fn next(&mut self, settings: &StopSettings, rate: Rate) -> Rate {
        let step = rate_per_period(settings.quick_stop_deceleration_deg_s2);
        self.command -= self.command.limited(step);
        self.periods = self.periods.saturating_add(1);
        let stands = self.command == Rate::ZERO && rate < STANDING && rate > -STANDING;
        self.standing = if stands {
            self.standing.saturating_add(1)
        } else {
            0
        };
        self.command
    }

    /// Whether it has ended.
    pub fn is_over(&self, settings: &StopSettings) -> bool {
        self.standing >= STANDING_PERIODS || self.periods >= periods(settings.quick_stop_ms)
    }

    /// Holds the shaft at this angle from now on.
    pub fn hold(&mut self, angle: Angle) {
        self.held = Some(angle);
    }

    /// The angle at which the shaft is held.
    pub fn holds_at(&self) -> Option<Angle> {
        self.held
    }
}

#[cfg(test)]
mod tests {
    use model_core::control::units::rate;

    use super::*;

    #[test]
    fn from_350_deg_s_the_ramp_ends_after_175_ms_and_the_stop_after_20_ms_at_rest() {
        for sign in [1, -1] {
            let mut stopping = Stopping::from(Rate::from_int(350 * sign));
            let settings = StopSettings::DEFAULT;
            let mut periods = 0;
            loop {
                let command = stopping.next(&settings, Rate::ZERO);
                periods += 1;
                // 8 deg/s a period.
                let expected = (350 - 8 * periods).max(0) * sign;
                assert_eq!(command, Rate::from_int(expected));
                if stopping.is_over(&settings) {
                    break;
                }
            }
            assert_eq!(periods, 44 + 4);
        }
    }

    /// Control periods of a stop of a shaft that keeps this rate, of 1000 at most.
    fn periods_at(rate: Rate) -> u32 {
        let mut stopping = Stopping::from(rate);
        let settings = StopSettings::DEFAULT;
        let mut periods = 0;
        while !stopping.is_over(&settings) && periods < 1000 {
            stopping.next(&settings, rate);
            periods += 1;
        }
        periods
    }

    #[test]
    fn a_shaft_that_does_not_stop_is_given_up_in_time() {
        assert_eq!(periods_at(Rate::from_int(100)), 125);
    }

    #[test]
    fn a_shaft_stands_below_5_deg_s_and_at_5_deg_s_it_turns() {
        for sign in [1, -1] {
            assert_eq!(periods_at(Rate::from_int(5 * sign)), 125);
            assert_eq!(periods_at(rate(4.99 * f64::from(sign))), 5);
        }
    }
}
