//! Temperature of the motor's winding, by the current.
//!
//! ```text
//! Cw dw/dt = i^2 R (1 + a (T - 25 deg C)) - (w - h)/Rwh        T = board + w
//! Ch dh/dt = (w - h)/Rwh - h/Rha
//! ```
//!
//! `w` and `h` are how much warmer winding and housing are than the board, which measures the air
//! around both; `i^2` is the mean square over the PWM period, since the current pulses; `a` is that
//! of copper. A missing sample leaves the heat of the period out. After a reset of the processor
//! both start at the temperature of the board; a reset of the node keeps them.

use super::Conditions;
use crate::{measure::MotorConstants, parameters::BoardParameters};

/// Rise of the resistance of copper, 1/K, from 25 deg C on.
const COPPER_K: f32 = 0.0039;
const COLD_DEG_C: f32 = 25.0;

/// The temperatures of the motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Winding {
    /// Winding and housing above the board, K.
    winding_k: f32,
    housing_k: f32,
    /// The board, deg C.
    board_deg_c: f32,
}

impl Default for Winding {
    fn default() -> Self {
        Self {
            winding_k: 0.0,
            housing_k: 0.0,
            board_deg_c: COLD_DEG_C,
        }
    }
}

impl Winding {
    /// One control period.
    pub(super) fn update(&mut self, motor: &MotorConstants, c: &Conditions<'_>) {
        if let Some(mdeg_c) = c.measured.temperature_mdeg_c {
            self.board_deg_c = mdeg_c as f32 * 1e-3;
        }
        let square_ma2 = c.measured.current.map_or(0, |current| current.square_ma2);
        let thermal = motor.thermal();
        let heated_k = square_ma2 as f32 * thermal.heating * self.resistance_ratio();
        let to_housing_k = self.winding_k - self.housing_k;
        self.winding_k += heated_k - to_housing_k * thermal.winding_rate;
        self.housing_k +=
            to_housing_k * thermal.housing_gain - self.housing_k * thermal.housing_rate;
    }

    /// The temperature of the winding, deg C.
    pub fn deg_c(&self) -> f32 {
        self.board_deg_c + self.winding_k
    }

    /// The resistance over that at 25 deg C.
    pub fn resistance_ratio(&self) -> f32 {
        1.0 + COPPER_K * (self.deg_c() - COLD_DEG_C)
    }

    /// How far the winding is below its limit, K.
    pub fn below_limit_k(&self, parameters: &BoardParameters) -> f32 {
        parameters.current.winding_mdeg_c as f32 * 1e-3 - self.deg_c()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        faults::Fault,
        measure::PeriodCurrent,
        parameters::ModelSettings,
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
        let motor = MotorConstants::of(&MODEL);
        let measured = Measured {
            current: Some(PeriodCurrent {
                mean_ma: 0,
                stall_ma: 0,
                square_ma2: (square_a2 * 1e6) as i32,
            }),
            temperature_mdeg_c: Some(25_000),
            ..UNMEASURED
        };
        let mut winding = Winding::default();
        for _ in 0..seconds * 1000 / CONTROL_PERIOD_MS {
            winding.update(&motor, &driven(&measured));
        }
        winding
    }

    #[test]
    fn the_steady_state_is_that_of_the_power_in_the_warm_winding() {
        // w = P (Rwh + Rha)/(1 - a P (Rwh + Rha)), with P = 0.16 * 7.7 W and 38 K/W.
        let cold_k = 0.16 * 7.7 * 38.0;
        let expected_k = cold_k / (1.0 - f64::from(COPPER_K) * cold_k);
        let found_k = f64::from(after(6000, 0.16).winding_k);
        // Single precision stops where a period changes h by less than 2^-19 K: at 2^-19/1.3e-5 =
        // 0.14 K, 0.18 K with the resistance.
        assert!(
            (found_k - expected_k).abs() < 0.25,
            "{found_k} {expected_k}"
        );
    }

    #[test]
    fn it_warms_with_the_time_constant_of_the_winding_over_the_housing() {
        // For small powers, where copper and housing hardly change: P Rwh (1 - exp(-t/Tw)) and the
        // housing's t/Ch P, less than a twentieth of it.
        let power_w = 0.01 * 7.7;
        let winding = after(10, 0.01);
        let over_k = f64::from(winding.winding_k - winding.housing_k);
        let expected_k = power_w * 8.0 * (1.0 - (-1.0_f64).exp());
        assert!(
            (over_k / expected_k - 1.0).abs() < 0.05,
            "{over_k} {expected_k}"
        );
    }

    #[test]
    fn an_overload_of_twice_the_rated_current_is_detected_within_the_stated_time() {
        let parameters = BoardParameters::DEFAULT;
        let stated_s = Fault::Overload.detected_ms(&parameters) as i32 / 1000;
        assert!(after(stated_s, 1.0).below_limit_k(&parameters) <= 0.5);
        assert!(after(stated_s - 1, 1.0).below_limit_k(&parameters) > 0.0);
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
        assert!(winding.below_limit_k(&BoardParameters::DEFAULT).abs() < 10.0);
    }
}
