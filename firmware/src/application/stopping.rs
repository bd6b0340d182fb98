//! The ramp that brings the shaft to rest.
//!
//! The commanded rate starts at the measured one and falls by `quick_stop_deceleration_deg_s2`
//! in a second. Once it is zero and the shaft has stood for five periods, or when
//! `quick_stop_ms` is over, the stop is done.

use model_core::control::units::{Angle, Rate, held};

use crate::{
    parameters::StopSettings,
    timing::{angle_per_period, periods},
};

/// The shaft stands below this rate: a quarter of one encoder count a period.
const STANDING: Rate = Rate::const_from_int(5);

/// Control periods for which it has to.
const STANDING_PERIODS: u8 = 5;

/// A quick stop on its way.
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
        // deg/s^2 times 4 ms are deg/s, as deg/s times 4 ms are deg.
        let step = angle_per_period(settings.quick_stop_deceleration_deg_s2);
        self.command -= held(self.command, step);
        self.periods = self.periods.saturating_add(1);
        let stands = self.command == Rate::ZERO && rate < STANDING && rate > -STANDING;
        self.standing = if stands {
            self.standing.saturating_add(1)
        } else {
            0
        };
        self.command
    }

    /// Whether it is done.
    pub fn is_over(&self, settings: &StopSettings) -> bool {
        self.standing >= STANDING_PERIODS || self.periods >= periods(settings.quick_stop_ms)
    }

    /// From now on the shaft is held here.
    pub fn hold(&mut self, angle: Angle) {
        self.held = Some(angle);
    }

    /// Where it is held, if it is.
    pub fn holds_at(&self) -> Option<Angle> {
        self.held
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn from_350_deg_s_the_ramp_ends_after_175_ms_and_the_stop_after_20_ms_at_rest() {
        for sign in [1, -1] {
            let mut stopping = Stopping::from(Rate::from_num(350 * sign));
            let settings = StopSettings::DEFAULT;
            let mut periods = 0;
            loop {
                let command = stopping.next(&settings, Rate::ZERO);
                periods += 1;
                // 8 deg/s a period.
                let expected = (350 - 8 * periods).max(0) * sign;
                assert_eq!(command, expected);
                if stopping.is_over(&settings) {
                    break;
                }
            }
            assert_eq!(periods, 44 + 4);
        }
    }

    #[test]
    fn a_shaft_that_does_not_stop_is_given_up_in_time() {
        let mut stopping = Stopping::from(Rate::from_num(100));
        let settings = StopSettings::DEFAULT;
        let mut periods = 0;
        while !stopping.is_over(&settings) {
            stopping.next(&settings, Rate::from_num(100));
            periods += 1;
        }
        assert_eq!(periods, 125);
    }
}
