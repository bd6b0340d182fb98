//! Temperature of the motor's winding, by the current.
//!
//! ```text
//! Cw dw/dt = i^2 R (1 + a (w - 25 deg C)) - (w - h)/Rwh
//! Ch dh/dt = (w - h)/Rwh - (h - b)/Rha
//! ```
//!
//! `w`, `h` and `b` are the temperatures of winding, housing and board, which measures that of the
//! air around both; `i^2` is the mean square over the PWM period, since the current pulses; `a` is
//! that of copper. A missing sample leaves the heat of the period out. After a reset of the
//! processor both start at the temperature of the board; a reset of the node keeps them.

use super::Conditions;
use crate::{interface::Settings, timing::periods};

/// Rise of the resistance of copper, 1/K, from 25 deg C on.
const COPPER_K: f32 = 0.0039;
const COLD_DEG_C: f32 = 25.0;

/// At the start both follow the board for so many measurements, with a quarter of the difference
/// each: a single wrong one leaves 1 % of its error.
const SETTLED: u8 = periods(80) as u8;

/// The temperatures end so far above the limit, K, and from a wrong current recover in a minute.
const BEYOND_K: f32 = 5.0;

/// The temperatures of the motor, deg C.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Winding {
    winding: f32,
    housing: f32,
    /// The board.
    air: f32,
    /// Measurements of the board's temperature, up to [`SETTLED`].
    measured: u8,
}

impl Default for Winding {
    fn default() -> Self {
        Self {
            winding: COLD_DEG_C,
            housing: COLD_DEG_C,
            air: COLD_DEG_C,
            measured: 0,
        }
    }
}

impl Winding {
    /// One control period.
    pub(super) fn update(&mut self, settings: Settings<'_>, c: &Conditions<'_>) {
        if let Some(mdeg_c) = c.measured.temperature_mdeg_c {
            self.air = mdeg_c as f32 * 1e-3;
            if self.measured < SETTLED {
                self.measured += 1;
                self.winding += (self.air - self.winding) / 4.0;
                self.housing = self.winding;
            }
        }
        let square_ma2 = c.measured.current.map_or(0, |current| current.square_ma2);
        let thermal = settings.motor.thermal();
        let heated_k = square_ma2 as f32 * thermal.heating * self.resistance_ratio();
        let (over_housing_k, over_air_k) = (self.winding - self.housing, self.housing - self.air);
        let end = settings.limits.winding_deg_c() + BEYOND_K;
        let winding = self.winding + heated_k - over_housing_k * thermal.winding_rate;
        self.winding = at_most(winding, end);
        let warmed_k = over_housing_k * thermal.housing_gain - over_air_k * thermal.housing_rate;
        self.housing = at_most(self.housing + warmed_k, end);
    }

    /// The temperature of the winding, deg C.
    pub fn deg_c(&self) -> f32 {
        self.winding
    }

    /// The resistance over that at 25 deg C.
    pub fn resistance_ratio(&self) -> f32 {
        1.0 + COPPER_K * (self.winding - COLD_DEG_C)
    }
}

/// The lower one; a temperature that is no number is the end.
fn at_most(deg_c: f32, end: f32) -> f32 {
    if deg_c < end { deg_c } else { end }
}

#[cfg(test)]
mod tests {
    use model_core::control::encoder_correction::EncoderCorrection;

    use super::*;
    use crate::{
        application::{DeadBandSettings, MotorLimits},
        faults::Fault,
        measure::{MotorConstants, PeriodCurrent},
        parameters::{BoardParameters, LimitSettings, ModelSettings},
        protection::{
            Measured,
            tests::{UNMEASURED, driven},
        },
        timing::CONTROL_PERIOD_MS,
    };

    /// 7.7 ohm, 8 and 30 K/W, 10 and 300 s.
    const MODEL: ModelSettings = ModelSettings::DEFAULT;

    /// A winding after so many seconds of this mean square, A^2, in a board of 25 deg C.
    fn after(seconds: i32, square_a2: f64) -> Winding {
        let parameters = BoardParameters::DEFAULT;
        let settings = Settings {
            board: &parameters,
            motor: &MotorConstants::of(&MODEL),
            limits: &MotorLimits::of(&LimitSettings::DEFAULT, &parameters, &MODEL),
            dead_band: &DeadBandSettings::default(),
            encoder: &EncoderCorrection::NONE,
            observes_rate: false,
        };
        let measured = Measured {
            current: Some(PeriodCurrent {
                square_ma2: (square_a2 * 1e6) as i32,
                ..PeriodCurrent::default()
            }),
            temperature_mdeg_c: Some(25_000),
            ..UNMEASURED
        };
        let mut winding = Winding::default();
        for _ in 0..seconds * 1000 / CONTROL_PERIOD_MS {
            winding.update(settings, &driven(&measured));
        }
        winding
    }

    #[test]
    fn the_steady_state_is_that_of_the_power_in_the_warm_winding() {
        // w = P (Rwh + Rha)/(1 - a P (Rwh + Rha)), with P = 0.16 * 7.7 W and 38 K/W.
        let cold_k = 0.16 * 7.7 * 38.0;
        let expected_k = cold_k / (1.0 - f64::from(COPPER_K) * cold_k);
        let found_k = f64::from(after(6000, 0.16).winding) - 25.0;
        // Single precision stops where a period changes h by less than half a step of 2^-17 K: at
        // 2^-18/1.3e-5 = 0.29 K, 0.36 K with the resistance; and likewise w.
        assert!((found_k - expected_k).abs() < 0.5, "{found_k} {expected_k}");
    }

    #[test]
    fn it_warms_with_the_time_constant_of_the_winding_over_the_housing() {
        // For small powers, where copper and housing hardly change: P Rwh (1 - exp(-t/Tw)) and the
        // housing's t/Ch P, less than a twentieth of it, and 80 ms at the start.
        let power_w = 0.01 * 7.7;
        let winding = after(10, 0.01);
        let over_k = f64::from(winding.winding - winding.housing);
        let expected_k = power_w * 8.0 * (1.0 - (-1.0_f64).exp());
        assert!(
            (over_k / expected_k - 1.0).abs() < 0.06,
            "{over_k} {expected_k}"
        );
    }

    #[test]
    fn an_overload_of_twice_the_rated_current_is_detected_within_the_stated_time() {
        let parameters = BoardParameters::DEFAULT;
        let limit_deg_c = parameters.current.winding_mdeg_c as f32 * 1e-3;
        let stated_s = Fault::Overload.detected_ms(&parameters) as i32 / 1000;
        assert!(after(stated_s, 1.0).deg_c() >= limit_deg_c - 0.5);
        assert!(after(stated_s - 1, 1.0).deg_c() < limit_deg_c);
    }

    #[test]
    fn no_current_warms_it_far_beyond_its_limit_nor_makes_it_a_number_of_no_size() {
        let winding = after(3000, 1600.0);
        assert!((winding.deg_c() - 125.0).abs() < 0.01);
    }

    #[test]
    fn the_rated_current_heats_a_winding_at_room_temperature_to_its_limit() {
        // 0.25 A^2 * 7.7 ohm * 38 K/W = 73 K cold, 102 K warm: 127 deg C, within 10 K of 120.
        let winding = after(6000, 0.25);
        assert!(
            (winding.deg_c() - 120.0).abs() < 10.0,
            "{}",
            winding.deg_c()
        );
    }
}
