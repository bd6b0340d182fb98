//! The ramp that brings the shaft to rest.
//!
//! The commanded rate starts at the measured one and falls by `quick_stop_deceleration_deg_s2` per
//! second. The shaft does not stand before the command is zero.

use model_core::control::units::{Angle, Rate};

use super::stop_progress::StopProgress;
use crate::{parameters::StopSettings, timing::rate_per_period};

/// The shaft stands below this rate: a quarter of one encoder count in 4 ms.
const STANDING: Rate = Rate::from_int(5);

/// The state of a quick stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Stopping {
    command: Rate,
    progress: StopProgress,
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
        let stands = self.command == Rate::ZERO && rate < STANDING && rate > -STANDING;
        self.progress.next(Some(stands));
        self.command
    }

    /// Whether it has ended.
    pub fn is_over(&self, settings: &StopSettings) -> bool {
        self.progress.is_over(settings)
    }

    /// How far the stop has come; one that holds the shaft has ended, and another stop starts anew.
    pub fn progress(&self) -> StopProgress {
        match self.held {
            Some(_) => StopProgress::default(),
            None => self.progress,
        }
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
