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

use super::back_emf_brake::{UNITS, units_of};
use crate::timing::{angle_of_mdeg, periods};

/// Three times 1/P: a motion of the default gains has ended.
const SETTLED_PERIODS: u16 = periods(375);

/// A mean of the duty takes a share of each new one, 2^-6 at 250 Hz: over 256 ms, since the noise
/// makes 12 %.
const MEAN_BITS: u32 = periods(256).ilog2();

/// When a shaft rests; by default never.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub struct DeadBandSettings {
    /// Half the width of the band, 2^-16 deg; 0 for none.
    band: i32,
    /// The voltage at the resistance that makes the torque of the Coulomb friction, mV, times the
    /// duty 100 % in units of the mean.
    friction: i32,
}

impl DeadBandSettings {
    /// Those of half the width of the band, and of the voltage at the resistance that makes the
    /// torque of the Coulomb friction, 33 V at most.
    pub fn new(band_mdeg: u16, friction_mv: i32) -> Self {
        Self {
            // Below 2^7 deg.
            band: (angle_of_mdeg(band_mdeg.into()).to_bits() >> 16) as i32,
            friction: friction_mv * UNITS,
        }
    }

    /// Whether a shaft ever rests.
    pub(super) fn is_on(&self) -> bool {
        self.band > 0
    }
}

/// How long the shaft has been within the band of the same angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct DeadBand {
    settled: u16,
    /// Mean duty meanwhile, in 2^-8 %.
    mean: i32,
}

impl DeadBand {
    /// Whether the shaft rests. `error` is its distance from the angle around which the loops are
    /// closed, if that has not changed, and `duty` that of the last step.
    pub fn rests(
        &mut self,
        settings: &DeadBandSettings,
        error: Option<Angle>,
        duty: Percent,
        supply_mv: i32,
    ) -> bool {
        let rests = self.settled == SETTLED_PERIODS;
        let edge = match rests {
            true => 2 * settings.band,
            false => settings.band,
        };
        let edge = Angle::from_bits(i64::from(edge) << 16);
        let is_near = error.is_some_and(|error| error.abs() <= edge);
        if !is_near {
            *self = Self {
                settled: 0,
                mean: units_of(duty),
            };
            return false;
        }
        self.mean += (units_of(duty) - self.mean) >> MEAN_BITS;
        // Below 2^15 times 16.5 V.
        let is_held = || self.mean.abs() * supply_mv < settings.friction;
        if self.settled + 1 < SETTLED_PERIODS || !rests && is_held() {
            self.settled += 1;
        }
        self.settled == SETTLED_PERIODS
    }
}

#[cfg(test)]
mod tests {
    use model_core::control::units::{angle, percent};

    use super::*;

    /// Periods until a shaft with this error and duty rests, of twice the time to settle.
    fn rests_after(dead_band: &mut DeadBand, angle_deg: f64, duty_pct: f64) -> Option<u16> {
        let (error, duty) = (Some(angle(angle_deg)), percent(duty_pct));
        let settings = DeadBandSettings::new(1000, 300);
        dead_band.rests(&settings, None, duty, 6000);
        (0..2 * SETTLED_PERIODS).find(|_| dead_band.rests(&settings, error, duty, 6000))
    }

    #[test]
    fn a_shaft_rests_where_it_has_settled_and_the_friction_holds_it() {
        let after =
            |angle_deg, duty_pct| rests_after(&mut DeadBand::default(), angle_deg, duty_pct);
        // 300 mV of 6 V are 5 %.
        assert_eq!(after(1.0, 4.9), Some(SETTLED_PERIODS - 1));
        assert_eq!(after(-1.0, -4.9), Some(SETTLED_PERIODS - 1));
        assert_eq!(after(1.0, 5.1), None, "loaded");
        assert_eq!(after(1.1, 0.0), None, "outside the band");
    }

    #[test]
    fn a_shaft_rests_up_to_twice_the_band_and_until_the_command_changes() {
        let settings = DeadBandSettings::new(1000, 300);
        let mut dead_band = DeadBand::default();
        assert!(rests_after(&mut dead_band, 0.0, 0.0).is_some());
        let mut rests_at = |error| dead_band.rests(&settings, error, Percent::ZERO, 6000);
        assert!(rests_at(Some(angle(2.0))));
        assert!(!rests_at(Some(angle(-2.1))));
        assert!(!rests_at(Some(Angle::ZERO)), "settles again");
        let mut dead_band = DeadBand::default();
        assert!(rests_after(&mut dead_band, 0.0, 0.0).is_some());
        assert!(!dead_band.rests(&settings, None, Percent::ZERO, 6000));
    }
}
