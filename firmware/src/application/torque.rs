//! The duty of a torque.
//!
//! The winding settles within a PWM period, so that the duty decides on the mean current, and with
//! it on the torque: with the supply `V`, the resistance `R` and the back-EMF `e` the current `i`
//! needs `duty = (e + i R)/V`. Its torque accelerates the shaft up to a rate whose back-EMF is
//! `e_max`; beyond that the duty opposes the difference as the brake does
//! ([`super::back_emf_brake`]), with `k = 4`:
//!
//! ```text
//! duty V <= e_max + k (e_max - e)
//! ```
//!
//! and likewise at the least rate. Where `e_max` is 0 this is the brake. The rate at which a torque
//! is held lies below `e_max` by what the current needs, `i R/(1 + k)`.
//!
//! The error of the torque is that of the resistance, and of the torque constant. The limits of
//! current, of the supply and of the winding's temperature act on the duty as on that of the loops.

use model_core::control::units::Percent;

use super::{
    TorqueSetpoint,
    back_emf_brake::{OPPOSING, duty_of},
};
use crate::{interface::Settings, protection::Winding};

/// Each supply is below this voltage, mV.
const GREATEST_MV: i32 = 33_000;

/// The duty of a torque, and whether a limit of the rate has changed it.
pub(super) fn duty(
    torque: TorqueSetpoint,
    settings: Settings<'_>,
    winding: &Winding,
    (back_emf_mv, supply_mv): (i32, i32),
) -> (Percent, bool) {
    let resistive_mv = settings.limits.resistive_mv(torque.permille, winding);
    let wanted_mv = back_emf_mv + resistive_mv;
    let bound = |rate_mdeg_s| {
        let end_mv = settings.motor.back_emf_mv(rate_mdeg_s);
        let bound_mv = end_mv + OPPOSING * (end_mv - back_emf_mv);
        bound_mv.clamp(-GREATEST_MV, GREATEST_MV)
    };
    let (slowest, fastest) = torque.rates_mdeg_s;
    let mean_mv = wanted_mv.min(bound(fastest)).max(bound(slowest));
    (duty_of(mean_mv, supply_mv), mean_mv != wanted_mv)
}
