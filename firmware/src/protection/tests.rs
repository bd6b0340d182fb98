//! Measurements and conditions for the tests of the protections.

use super::*;

/// No measurement at all.
pub(super) const UNMEASURED: Measured = Measured {
    count: None,
    travelled: None,
    magnet: None,
    sampled_ma: None,
    current: None,
    back_emf_mv: None,
    supply_mv: None,
    temperature_mdeg_c: None,
};

/// A current that is constant within the PWM period.
pub(super) fn smooth(mean_ma: i32) -> Option<PeriodCurrent> {
    Some(PeriodCurrent {
        mean_ma,
        stall_ma: mean_ma,
        square_ma2: mean_ma * mean_ma,
    })
}

/// A driven motor at rest with these measurements.
pub(super) fn driven(measured: &Measured) -> Conditions<'_> {
    Conditions {
        measured,
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
    }
}
