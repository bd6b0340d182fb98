//! The limit of the motor's current, and with it of its torque.
//!
//! The winding settles within a PWM period, so that the duty decides on the mean current: with the
//! supply `V`, the resistance `R` and the back-EMF `e`
//!
//! ```text
//! i = (duty V - e)/R,  hence  |i| <= limit  for  (e - R limit)/V <= duty <= (e + R limit)/V
//! ```
//!
//! The back-EMF is up to 5 ms old. A motor that accelerates with its stall torque changes it by
//! `V T/(mechanical time constant)` = 6 V x 5/132 = 0.23 V meanwhile, 4 % of the stall current. The
//! resistance is that of the winding at its temperature.
//!
//! The duty of the brake ([`super::back_emf_brake`]) is allowed in any case: a load that overcomes
//! the limited torque turns the shaft no faster than it turns the braked one.
//!
//! The limit is the least of
//!
//! - 6072h and 6073h;
//! - what the winding's temperature leaves: it decreases to zero over the last
//!   [`DERATING_K`] below the limit of the temperature;
//! - what the supply leaves: below [`FOLDING_MV`] above `under_voltage_mv` it decreases from the
//!   present current by a third of the missing voltage, mA per mV, in each control period: stable
//!   for a source of up to 6 ohm, and for 3 ohm right after one period. The duty of the brake
//!   decreases with it, down to the shorted motor, which takes nothing from the supply.

use model_core::control::units::Percent;

use super::back_emf_brake::duty_of;
use crate::{interface::Settings, protection::Winding};

/// Below the winding's limit the current decreases over so many K.
const DERATING_K: f32 = 15.0;

/// Supply voltage above `under_voltage_mv` from which the current is reduced, mV.
const FOLDING_MV: i32 = 300;

/// The current is reduced by a third of the missing voltage in each control period, and returns by
/// a sixteenth of what is more.
const FOLDING: i32 = 3;
const RETURNING: i32 = 16;

/// No current needs more than this voltage: the legs are measured up to 16.5 V.
const GREATEST_MV: f32 = 33_000.0;

/// What reduces the limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct CurrentLimit {
    /// What the supply takes from the limit, mA.
    folded_ma: i32,
    /// Whether supply or winding take something from it.
    is_reduced: bool,
}

impl CurrentLimit {
    /// Whether the limit is below that of 6072h and 6073h.
    pub fn is_reduced(self) -> bool {
        self.is_reduced
    }

    /// Takes the supply voltage and the mean current of a control period.
    pub fn observe(&mut self, settings: Settings<'_>, supply_mv: i32, mean_ma: i32) {
        let missing_mv = settings.board.supply.under_voltage_mv + FOLDING_MV - supply_mv;
        if self.folded_ma == 0 && missing_mv <= 0 {
            return;
        }
        let commanded_ma = commanded_ma(settings);
        let folded_ma = if missing_mv > 0 {
            self.folded_ma.max(commanded_ma - mean_ma.abs()) + missing_mv / FOLDING
        } else {
            self.folded_ma + missing_mv / RETURNING
        };
        self.folded_ma = folded_ma.clamp(0, commanded_ma);
    }

    /// The limit at the temperature of the winding, mA.
    pub fn next(&mut self, settings: Settings<'_>, winding: &Winding) -> i32 {
        let commanded_ma = commanded_ma(settings);
        let left_k = winding.below_limit_k(settings.board);
        let derated_ma = if left_k < DERATING_K {
            (commanded_ma as f32 * (left_k / DERATING_K)) as i32
        } else {
            commanded_ma
        };
        let limit_ma = derated_ma.min(commanded_ma - self.folded_ma).max(0);
        self.is_reduced = limit_ma < commanded_ma;
        limit_ma
    }

    /// The greatest duty of the brake: less by what the supply takes.
    pub fn braking_duty(self, settings: Settings<'_>) -> Percent {
        let limit = settings.board.control.duty_limit();
        if self.folded_ma == 0 {
            return limit;
        }
        // The folded current is at most the commanded one.
        let left_pct = 100 - 100 * self.folded_ma / commanded_ma(settings).max(1);
        limit.limited(Percent::from_int(left_pct))
    }
}

/// The limit by 6072h and 6073h, in thousandths of the rated current: the rated torque is that of
/// the rated current.
fn commanded_ma(settings: Settings<'_>) -> i32 {
    let limits = settings.limits;
    let permille = limits.max_torque_permille.min(limits.max_current_permille);
    // Below 2^16 times 1600.
    i32::from(permille) * settings.board.current.rated_ma / 1000
}

/// The duties within which the mean current stays below its limit; `None` where every one does.
pub(super) fn window(
    limit_ma: i32,
    resistance_ohm: f32,
    (back_emf_mv, supply_mv): (i32, i32),
) -> Option<(Percent, Percent)> {
    let span_mv = (limit_ma as f32 * resistance_ohm).min(GREATEST_MV) as i32;
    if span_mv >= supply_mv + back_emf_mv.abs() {
        return None;
    }
    let least = duty_of(back_emf_mv - span_mv, supply_mv);
    let most = duty_of(back_emf_mv + span_mv, supply_mv);
    Some((least, most))
}
