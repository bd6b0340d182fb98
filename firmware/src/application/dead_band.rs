//! The dead band at rest.
//!
//! The loop amplifies the noise of the encoder: a count that changes within a control period is
//! 22 deg/s, of which the default filter passes 0.4 and the default gain makes 12 % of duty. A
//! shaft that is where it is commanded needs none of it. It rests once it has been within the band
//! of an angle that does not change, for [`SETTLED_PERIODS`], and until the error exceeds twice the
//! band, where noise does not reach, or the command changes.
//!
//! Meanwhile the duty is 0: the friction holds the shaft. One whose mean duty makes more torque
//! than the friction is loaded and does not rest: the duty that holds a load changes with the
//! temperature of the winding, and its sign does not change with the noise.

use model_core::control::units::{Angle, Percent};

use super::back_emf_brake::duty_of;
use crate::timing::periods;

/// Three times 1/P: a motion of the default gains has ended.
const SETTLED_PERIODS: u16 = periods(375);

/// A mean of the duty takes a sixteenth of each new one.
const MEAN_BITS: u32 = 4;

/// When a shaft rests; by default never.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub struct DeadBandSettings {
    /// Half the width of the band; 0 for none.
    pub band: Angle,
    /// The voltage at the resistance that makes the torque of the Coulomb friction, mV.
    pub friction_mv: i32,
}

/// How long the shaft has been within the band of the same angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct DeadBand {
    command: Angle,
    settled: u16,
    mean: Percent,
}

impl DeadBand {
    /// Whether the shaft rests. `command` is the angle around which the loops are closed, and `duty`
    /// that of the last step.
    pub fn rests(
        &mut self,
        settings: &DeadBandSettings,
        command: Option<Angle>,
        (angle, duty): (Angle, Percent),
        supply_mv: i32,
    ) -> bool {
        let Some(command) = command.filter(|_| settings.band > Angle::ZERO) else {
            *self = Self::default();
            return false;
        };
        let was_settled = self.settled == SETTLED_PERIODS;
        let edge = match was_settled {
            true => settings.band.saturating_add(settings.band),
            false => settings.band,
        };
        if command != self.command || command.saturating_sub(angle).abs() > edge {
            *self = Self {
                command,
                settled: 0,
                mean: duty,
            };
            return false;
        }
        self.settled = (self.settled + 1).min(SETTLED_PERIODS);
        self.mean += Percent::from_bits((duty - self.mean).to_bits() >> MEAN_BITS);
        was_settled && self.mean.abs() < duty_of(settings.friction_mv, supply_mv)
    }
}

#[cfg(test)]
mod tests {
    use model_core::control::units::{angle, percent};

    use super::*;

    const SETTINGS: DeadBandSettings = DeadBandSettings {
        band: Angle::from_int(1),
        friction_mv: 300,
    };

    /// Periods until a shaft at this angle and duty rests at 0 deg, of twice the time to settle.
    fn rests_after(dead_band: &mut DeadBand, angle_deg: f64, duty_pct: f64) -> Option<u16> {
        let last = (angle(angle_deg), percent(duty_pct));
        (0..2 * SETTLED_PERIODS).find(|_| dead_band.rests(&SETTINGS, Some(Angle::ZERO), last, 6000))
    }

    #[test]
    fn a_shaft_rests_where_it_has_settled_and_the_friction_holds_it() {
        let after =
            |angle_deg, duty_pct| rests_after(&mut DeadBand::default(), angle_deg, duty_pct);
        // 300 mV of 6 V are 5 %.
        assert_eq!(after(1.0, 4.9), Some(SETTLED_PERIODS));
        assert_eq!(after(-1.0, -4.9), Some(SETTLED_PERIODS));
        assert_eq!(after(1.0, 5.1), None, "loaded");
        assert_eq!(after(1.1, 0.0), None, "outside the band");
    }

    #[test]
    fn a_shaft_rests_up_to_twice_the_band_and_until_the_command_changes() {
        let mut dead_band = DeadBand::default();
        assert!(rests_after(&mut dead_band, 0.0, 0.0).is_some());
        let mut rests_at = |command, angle_deg| {
            let last = (angle(angle_deg), Percent::ZERO);
            dead_band.rests(&SETTINGS, command, last, 6000)
        };
        assert!(rests_at(Some(Angle::ZERO), 2.0));
        assert!(!rests_at(Some(Angle::ZERO), 2.1));
        assert!(!rests_at(Some(Angle::ZERO), 0.0));
        let mut dead_band = DeadBand::default();
        assert!(rests_after(&mut dead_band, 0.0, 0.0).is_some());
        let last = (Angle::ZERO, Percent::ZERO);
        assert!(!dead_band.rests(&SETTINGS, Some(angle(0.1)), last, 6000));
        assert!(
            !dead_band.rests(&SETTINGS, None, last, 6000),
            "around a rate"
        );
    }
}
