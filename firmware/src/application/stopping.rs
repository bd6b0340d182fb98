//! The ramp that brings the shaft to rest.
//!
//! The commanded rate starts at the measured one and falls by `quick_stop_deceleration_deg_s2` per
//! second. The shaft does not stand before the command is zero.
//!
//! A stop does not turn the shaft back: the control law starts without the duty that accelerated
//! the shaft, and when the shaft has come to rest, without the duty that decelerated it.

use model_core::control::units::{Angle, Rate};

use super::stop_progress::StopProgress;
use crate::{parameters::StopSettings, timing::rate_per_period};

/// The shaft stands below this rate: a quarter of one encoder count in 4 ms.
const STANDING: Rate = Rate::from_int(5);

/// Whether the shaft stands, by this rate.
pub(super) fn stands(rate: Rate) -> bool {
    rate < STANDING && rate > -STANDING
}

/// The state of a quick stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Stopping {
    command: Rate,
    /// The sign of the rate at which the stop began; 0 of a shaft that stood and was to.
    direction: i8,
    progress: StopProgress,
    held: Option<Angle>,
}

impl Stopping {
    /// A stop from this rate. A shaft that still stands, but was to turn, begins to: `demanded` is
    /// the rate that was commanded.
    pub fn from(rate: Rate, demanded: Rate) -> Self {
        let turns = if stands(rate) { demanded } else { rate };
        Self {
            command: rate,
            direction: if stands(turns) { 0 } else { sign(turns) },
            ..Self::default()
        }
    }

    /// The commanded rate of this period, while the shaft turns at `rate`.
    pub fn next(&mut self, settings: &StopSettings, rate: Rate) -> Rate {
        let step = rate_per_period(settings.quick_stop_deceleration_deg_s2);
        self.command -= self.command.limited(step);
        let stands = self.command == Rate::ZERO && stands(rate);
        self.progress.next(Some(stands));
        self.command
    }

    /// Whether the shaft turned when the stop began.
    pub fn began_in_motion(&self) -> bool {
        self.direction != 0
    }

    /// Whether the shaft has just come to rest or turns back. At the start of a motion the measured
    /// rate is that of a shaft at rest.
    pub fn arrives(&self, rate: Rate) -> bool {
        let has_turned = stands(rate) || sign(rate) != self.direction;
        self.held.is_none() && has_turned && self.progress.has_settled()
    }

    /// Whether the shaft has come to rest; whatever time that takes.
    pub fn is_over(&self, settings: &StopSettings) -> bool {
        self.held.is_some() && self.is_late(settings)
    }

    /// Whether the shaft has come to rest, or the time is over.
    pub fn is_late(&self, settings: &StopSettings) -> bool {
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
        (self.command, self.held) = (Rate::ZERO, Some(angle));
    }

    /// The angle at which the shaft is held.
    pub fn holds_at(&self) -> Option<Angle> {
        self.held
    }
}

fn sign(rate: Rate) -> i8 {
    i8::from(rate > Rate::ZERO) - i8::from(rate < Rate::ZERO)
}

#[cfg(test)]
mod tests {
    use model_core::control::units::rate;

    use super::*;

    const SETTINGS: StopSettings = StopSettings::DEFAULT;

    /// One control period at this rate; returns the commanded rate.
    fn next(stopping: &mut Stopping, rate: Rate) -> Rate {
        let command = stopping.next(&SETTINGS, rate);
        if stopping.arrives(rate) {
            stopping.hold(Angle::ZERO);
        }
        command
    }

    #[test]
    fn from_350_deg_s_the_ramp_ends_after_175_ms() {
        for sign in [1, -1] {
            let mut stopping = Stopping::from(Rate::from_int(350 * sign), Rate::ZERO);
            for period in 1..60 {
                let command = next(&mut stopping, Rate::from_int(100 * sign));
                // 8 deg/s a period.
                let expected = (350 - 8 * period).max(0) * sign;
                assert_eq!(command, Rate::from_int(expected));
            }
        }
    }

    /// Control periods until a stop from 80 deg/s is late, and until it is over, of a shaft that
    /// has this rate from then on; within 1000.
    fn periods_at(rate: Rate) -> (Option<u32>, Option<u32>) {
        let mut stopping = Stopping::from(Rate::from_int(80), Rate::ZERO);
        let (mut late, mut over) = (None, None);
        for period in 1..=1000 {
            next(&mut stopping, rate);
            late = late.or(stopping.is_late(&SETTINGS).then_some(period));
            over = over.or(stopping.is_over(&SETTINGS).then_some(period));
        }
        (late, over)
    }

    #[test]
    fn a_shaft_that_does_not_stop_is_late_and_the_stop_is_not_over() {
        assert_eq!(periods_at(Rate::from_int(100)), (Some(125), None));
        assert_eq!(periods_at(Rate::from_int(5)), (Some(125), None));
    }

    #[test]
    fn a_shaft_stands_below_5_deg_s() {
        // It is held after 20 ms, which ends the ramp, and has to stand for 20 ms.
        for sign in [1.0, -1.0] {
            assert_eq!(periods_at(rate(4.99 * sign)), (Some(10), Some(10)));
        }
    }

    #[test]
    fn a_shaft_that_turns_back_has_come_to_rest_and_is_given_its_time() {
        assert_eq!(periods_at(Rate::from_int(-20)), (Some(125), Some(125)));
    }
}
