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
//! ([`super::back_emf_brake`]) is allowed in any case: a load that overcomes the limited torque
//! turns the shaft no faster than it turns the braked one.
//!
//! A weak supply is relieved while the motor is driven: it gives `duty i`, so that its current is
//! at most `s` for
//!
//! ```text
//! (e - r)/(2 V) <= duty <= (e + r)/(2 V),   r^2 = e^2 + 4 V R s
//! ```
//!
//! Below [`FOLDING_MV`] above `under_voltage_mv` the limit `s` decreases from the present current
//! of the supply by a third of the missing voltage, mA per mV, in each control period, and by no
//! more than to [`LEAST_SUPPLY_MA`]: a supply whose voltage is low anyway still moves the shaft. A
//! third is stable for a source of up to 6 ohm. Only the enabled drive is limited by that: in a
//! stop, and after a fault, its load would fall.

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

/// The limit of the current of the supply ends here, mA: at 4.1 V a stalled motor of 7.7 ohm then
/// has a duty of 0.61, 0.33 A and 0.38 N m.
const LEAST_SUPPLY_MA: i32 = 200;

/// No motor takes more from its supply, mA: its legs are measured up to 16.5 V.
const GREATEST_MA: i32 = 30_000;

/// No current needs more than this voltage, mV.
const GREATEST_MV: f32 = 33_000.0;

/// The limits of current and temperature of the motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct MotorLimits {
    /// The lower one of 6072h and 6073h, mA: the rated torque is that of the rated current.
    current_ma: Single,
    /// 6075h, mA.
    rated_ma: Single,
    resistance_ohm: Single,
    /// The voltage of this current at the resistance of the cold winding, mV.
    voltage_mv: i32,
    /// Temperature of the winding from which the current decreases, deg C.
    derated_deg_c: Single,
    /// The limit of this temperature.
    winding_deg_c: Single,
}

impl MotorLimits {
    /// Those of these parameters.
    pub fn of(limits: &LimitSettings, board: &BoardParameters, model: &ModelSettings) -> Self {
        let permille = limits.max_torque_permille.min(limits.max_current_permille);
        // Below 2^16 times 1600.
        let current_ma = (i32::from(permille) * board.current.rated_ma) as f32 * 1e-3;
        let winding_deg_c = board.current.winding_mdeg_c as f32 * 1e-3;
        Self {
            current_ma: Single::new(current_ma),
            rated_ma: Single::new(board.current.rated_ma as f32),
            resistance_ohm: Single::new(model.resistance_ohm),
            voltage_mv: within(current_ma * model.resistance_ohm),
            derated_deg_c: Single::new(winding_deg_c - DERATING_K),
            winding_deg_c: Single::new(winding_deg_c),
        }
    }

    /// The voltage at the resistance of this winding that makes a torque, in thousandths of the
    /// rated one; mV.
    pub(super) fn resistive_mv(&self, permille: i16, winding: &Winding) -> i32 {
        let resistance_ohm = self.resistance_ohm.get() * winding.resistance_ratio();
        within(f32::from(permille) * 1e-3 * self.rated_ma.get() * resistance_ohm)
    }

    /// Whether the current of this winding is reduced.
    fn derates(&self, winding: &Winding) -> bool {
        winding.deg_c() >= self.derated_deg_c.get()
    }

    /// The limit of the winding's temperature, deg C.
    pub(crate) fn winding_deg_c(&self) -> f32 {
        self.winding_deg_c.get()
    }

    /// Whether this winding is too hot.
    pub(crate) fn is_exceeded(&self, winding: &Winding) -> bool {
        winding.deg_c() >= self.winding_deg_c.get()
    }
}

/// A voltage, mV, within [`GREATEST_MV`].
fn within(voltage_mv: f32) -> i32 {
    voltage_mv.clamp(-GREATEST_MV, GREATEST_MV) as i32
}

/// Least and greatest duty.
pub(super) type Window = (Percent, Percent);

/// The limit of the current of the supply, mA; `None` of a supply that holds its voltage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct CurrentLimit {
    supply_ma: Option<i32>,
}

impl CurrentLimit {
    /// Whether supply or winding reduce the current.
    pub fn is_reduced(self, limits: &MotorLimits, winding: &Winding) -> bool {
        self.supply_ma.is_some() || limits.derates(winding)
    }

    /// Takes the supply voltage and the current of a control period with this back-EMF.
    pub fn observe(
        &mut self,
        settings: Settings<'_>,
        (back_emf_mv, supply_mv): (i32, i32),
        current: PeriodCurrent,
    ) {
        let missing_mv = settings.board.supply.under_voltage_mv + FOLDING_MV - supply_mv;
        if self.supply_ma.is_none() && missing_mv <= 0 {
            return;
        }
        let before_ma = self.supply_ma.unwrap_or(GREATEST_MA);
        let supply_ma = if missing_mv > 0 {
            // The power of resistance and motor: the current pulses, so that its mean square
            // counts.
            let resistance_ohm = settings.limits.resistance_ohm.get();
            let of_motor = back_emf_mv as f32 * current.mean_ma as f32;
            let power_uw = resistance_ohm * current.square_ma2 as f32 + of_motor;
            let drawn_ma = (power_uw / supply_mv.max(1) as f32) as i32;
            before_ma.min(drawn_ma) - missing_mv / FOLDING
        } else {
            before_ma + 1 - missing_mv / RETURNING
        };
        let is_over = supply_ma >= settings.board.current.over_current_ma;
        self.supply_ma = (!is_over).then_some(supply_ma.max(LEAST_SUPPLY_MA));
    }

    /// A drive that is not enabled is not limited by its supply.
    pub fn reset(&mut self) {
        self.supply_ma = None;
    }

    /// The duties that are permitted at these voltages of back-EMF and supply, if not all are;
    /// `braking` is that of the brake.
    #[inline(always)]
    pub fn window(
        self,
        limits: &MotorLimits,
        winding: &Winding,
        voltages: (i32, i32),
        braking: impl FnOnce() -> Percent,
    ) -> Option<Window> {
        // A warm winding has a greater resistance and permits more duty.
        if !self.is_reduced(limits, winding) && permits_all(limits.voltage_mv, voltages) {
            return None;
        }
        self.narrow(limits, winding, voltages, braking())
    }

    #[inline(never)]
    fn narrow(
        self,
        limits: &MotorLimits,
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

#[cfg(test)]
mod tests {
    use model_core::control::encoder_correction::EncoderCorrection;
    use proptest::prelude::*;

    use super::*;
    use crate::{application::DeadBandSettings, measure::MotorConstants};

    #[test]
    fn the_current_of_a_supply_that_sags_only_decreases_and_returns_slowly() {
        let (board, model) = (BoardParameters::DEFAULT, ModelSettings::DEFAULT);
        let settings = Settings {
            board: &board,
            motor: &MotorConstants::of(&model),
            limits: &MotorLimits::of(&LimitSettings::DEFAULT, &board, &model),
            dead_band: &DeadBandSettings::default(),
            encoder: &EncoderCorrection::NONE,
            observes_rate: false,
        };
        let mut limit = CurrentLimit::default();
        let mut after = |supply_mv, mean_ma: i32| {
            let current = PeriodCurrent {
                mean_ma,
                square_ma2: mean_ma * mean_ma,
                ..PeriodCurrent::default()
            };
            limit.observe(settings, (0, supply_mv), current);
            limit.supply_ma
        };
        assert_eq!(after(4300, 700), None);
        // 700 mA at 7.7 ohm are 3.77 W, 943 mA at 4 V, less a third of 300 mV.
        assert_eq!(after(4000, 700), Some(843));
        assert_eq!(
            after(4000, 1000),
            Some(743),
            "a greater current raises no limit"
        );
        // 1/16 of 320 mV, and 1.
        assert_eq!(after(4620, 0), Some(764));
        assert_eq!(after(4300, 0), Some(765));
        // To the least one, and above the over-current to none.
        assert_eq!(
            (0..10).fold(None, |_, _| after(3900, 700)),
            Some(LEAST_SUPPLY_MA)
        );
        assert_eq!((0..200).fold(None, |_, _| after(6000, 0)), None);
    }

    proptest! {
        #[test]
        fn a_window_permits_no_more_than_the_limit_and_always_to_coast_or_brake(
            resistance_ohm in 0.05f32..1400.0,
            supply_ma in LEAST_SUPPLY_MA..2800,
            span_mv in 0..33_000,
            back_emf_mv in -16_500..16_500,
            supply_mv in 0..16_500,
        ) {
            let voltages = (back_emf_mv, supply_mv);
            let windows = [of_motor(span_mv, voltages), Some(of_supply(supply_ma, resistance_ohm, voltages))];
            for (least, most) in windows.into_iter().flatten() {
                prop_assert!(least <= most);
                prop_assert!(least >= Percent::from_int(-100) && most <= Percent::from_int(100));
            }
            let (least, most) = of_supply(supply_ma, resistance_ohm, voltages);
            prop_assert!(least <= Percent::ZERO && Percent::ZERO <= most);
            // The current of the supply at the ends, where the duty is not limited by 100 %.
            for duty in [least, most].map(|duty| duty.to_f64() / 100.0) {
                let (v, e) = (f64::from(supply_mv), f64::from(back_emf_mv));
                let drawn_ma = duty * (duty * v - e) / f64::from(resistance_ohm);
                // A step of the duty is 4e-5, and half a mV is lost in the root: of voltages that
                // make (2 duty V - e)/R of current of the supply per duty.
                let step_mv = (1.0 + 8e-5 * v) * (2.0 + e.abs() / v.max(1.0));
                let step_ma = step_mv / f64::from(resistance_ohm);
                prop_assert!(drawn_ma <= f64::from(supply_ma) + step_ma, "{}", drawn_ma);
                let is_free = duty.abs() < 0.999;
                prop_assert!(!is_free || drawn_ma >= f64::from(supply_ma) - step_ma, "{}", drawn_ma);
            }
        }
    }
}
