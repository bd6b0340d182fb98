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
//! The limit is the lower one of 6072h and 6073h, over the last [`DERATING_K`] below the limit of
//! the winding's temperature in proportion to what is left. The duty of the brake
//! ([`super::back_emf_brake`]) is allowed in any case: a load that overcomes the limited torque turns
//! the shaft no faster than it turns the braked one.
//!
//! A weak supply is relieved while the motor is driven: it gives `duty i`, so that its current is
//! at most `s` for
//!
//! ```text
//! (e - r)/(2 V) <= duty <= (e + r)/(2 V),   r^2 = e^2 + 4 V R s
//! ```
//!
//! Below [`FOLDING_MV`] above `under_voltage_mv` the limit `s` decreases from the present current of
//! the supply by a third of the missing voltage, mA per mV, in each control period: stable for a
//! source of up to 6 ohm. The brake after a fault is not limited by that: its load would fall.

use model_core::control::units::Percent;

use super::back_emf_brake::duty_of;
use crate::{
    interface::Settings,
    measure::{PeriodCurrent, Single},
    parameters::{BoardParameters, LimitSettings, ModelSettings},
    protection::Winding,
};

/// Below the winding's limit the current decreases over so many K.
const DERATING_K: f32 = 15.0;

/// Supply voltage above `under_voltage_mv` from which the current is reduced, mV.
const FOLDING_MV: i32 = 300;

/// The current of the supply is reduced by a third of the missing voltage in each control period,
/// and returns by a sixteenth of what is more.
const FOLDING: i32 = 3;
const RETURNING: i32 = 16;

/// No motor takes more from its supply, mA: its legs are measured up to 16.5 V.
const GREATEST_MA: i32 = 30_000;

/// No current needs more than this voltage, mV.
const GREATEST_MV: f32 = 33_000.0;

/// The limits of current and temperature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CurrentLimits {
    /// The lower one of 6072h and 6073h, mA: the rated torque is that of the rated current.
    current_ma: Single,
    resistance_ohm: Single,
    /// The voltage of this current at the resistance of the cold winding, mV.
    voltage_mv: i32,
    /// Temperature of the winding from which the current decreases, deg C.
    derated_deg_c: Single,
    /// The limit of this temperature.
    winding_deg_c: Single,
}

impl CurrentLimits {
    /// Those of these parameters.
    pub fn of(limits: &LimitSettings, board: &BoardParameters, model: &ModelSettings) -> Self {
        let permille = limits.max_torque_permille.min(limits.max_current_permille);
        // Below 2^16 times 1600.
        let current_ma = (i32::from(permille) * board.current.rated_ma) as f32 * 1e-3;
        let winding_deg_c = board.current.winding_mdeg_c as f32 * 1e-3;
        Self {
            current_ma: Single::new(current_ma),
            resistance_ohm: Single::new(model.resistance_ohm),
            voltage_mv: within(current_ma * model.resistance_ohm),
            derated_deg_c: Single::new(winding_deg_c - DERATING_K),
            winding_deg_c: Single::new(winding_deg_c),
        }
    }

    /// Whether this winding is too hot.
    pub(crate) fn is_exceeded(&self, winding: &Winding) -> bool {
        winding.deg_c() >= self.winding_deg_c.get()
    }
}

/// A voltage, mV.
fn within(voltage_mv: f32) -> i32 {
    if voltage_mv < GREATEST_MV {
        voltage_mv as i32
    } else {
        GREATEST_MV as i32
    }
}

/// Least and greatest duty.
pub(super) type Window = (Percent, Percent);

/// What limits the current.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct CurrentLimit {
    /// Limit of the current of the supply, mA; `None` of a supply that holds its voltage.
    supply_ma: Option<i32>,
    /// Whether supply or winding reduce the current.
    is_reduced: bool,
}

impl CurrentLimit {
    /// Whether the limit is below that of 6072h and 6073h.
    pub fn is_reduced(self) -> bool {
        self.is_reduced
    }

    /// Takes the supply voltage, and the current of a control period with this duty.
    pub fn observe(
        &mut self,
        settings: Settings<'_>,
        supply_mv: i32,
        (current, duty): (PeriodCurrent, Percent),
    ) {
        let missing_mv = settings.board.supply.under_voltage_mv + FOLDING_MV - supply_mv;
        if self.supply_ma.is_none() && missing_mv <= 0 {
            return;
        }
        let before_ma = self.supply_ma.unwrap_or(GREATEST_MA);
        let supply_ma = if missing_mv > 0 {
            // Within 2^15 mA and 100 %.
            let drawn_ma = (current.mean_ma * duty.to_int() / 100).abs();
            before_ma.min(drawn_ma) - missing_mv / FOLDING
        } else {
            before_ma - missing_mv / RETURNING
        };
        let is_over = supply_ma >= settings.board.current.over_current_ma;
        self.supply_ma = (!is_over).then_some(supply_ma.max(0));
    }

    /// The duties that are permitted at these voltages of back-EMF and supply, if not all are;
    /// `braking` is that of the brake.
    #[inline(always)]
    pub fn window(
        &mut self,
        limits: &CurrentLimits,
        winding: &Winding,
        voltages: (i32, i32),
        braking: impl FnOnce() -> Percent,
    ) -> Option<Window> {
        let is_hot = winding.deg_c() >= limits.derated_deg_c.get();
        self.is_reduced = is_hot || self.supply_ma.is_some();
        // A warm winding has a greater resistance, so that even fewer duties are excluded.
        if !self.is_reduced && permits_all(limits.voltage_mv, voltages) {
            return None;
        }
        self.narrow(limits, winding, voltages, braking())
    }

    #[inline(never)]
    fn narrow(
        self,
        limits: &CurrentLimits,
        winding: &Winding,
        voltages: (i32, i32),
        braking: Percent,
    ) -> Option<Window> {
        let resistance_ohm = limits.resistance_ohm.get() * winding.resistance_ratio();
        let left = (limits.winding_deg_c.get() - winding.deg_c()) / DERATING_K;
        let share = if left < 0.0 {
            0.0
        } else if left < 1.0 {
            left
        } else {
            1.0
        };
        let span_mv = within(limits.current_ma.get() * share * resistance_ohm);
        let of_motor = of_motor(span_mv, voltages)
            .map(|(least, most)| (least.min(braking), most.max(braking)));
        let of_supply = (self.supply_ma).map(|ma| of_supply(ma, resistance_ohm, voltages));
        match (of_motor, of_supply) {
            (Some(motor), Some(supply)) => Some((motor.0.max(supply.0), motor.1.min(supply.1))),
            (motor, supply) => motor.or(supply),
        }
    }
}

/// Whether no duty makes more than this voltage at the resistance.
fn permits_all(span_mv: i32, (back_emf_mv, supply_mv): (i32, i32)) -> bool {
    span_mv >= supply_mv + back_emf_mv.abs()
}

/// The duties within which the mean current makes no more than this voltage at the resistance;
/// `None` where every one does.
fn of_motor(span_mv: i32, voltages: (i32, i32)) -> Option<Window> {
    if permits_all(span_mv, voltages) {
        return None;
    }
    let (back_emf_mv, supply_mv) = voltages;
    let duty = |mean_mv| duty_of(mean_mv, supply_mv);
    Some((duty(back_emf_mv - span_mv), duty(back_emf_mv + span_mv)))
}

/// The duties at which the supply gives at most this current.
fn of_supply(supply_ma: i32, resistance_ohm: f32, (back_emf_mv, supply_mv): (i32, i32)) -> Window {
    let (e, v) = (back_emf_mv as f32, supply_mv as f32);
    let r = libm::sqrtf(e * e + 4.0 * v * resistance_ohm * supply_ma as f32);
    let duty = |twice_mv: f32| duty_of(within(twice_mv * 0.5), supply_mv);
    (duty(e - r), duty(e + r))
}
