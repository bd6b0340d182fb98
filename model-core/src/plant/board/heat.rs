//! The heat of the motor: a winding in a housing in the air.
//!
//! ```text
//! Cw dw/dt = i^2 R (1 + a (w - 25 deg C)) - (w - h)/Rwh
//! Ch dh/dt = (w - h)/Rwh - (h - air)/Rha
//! ```
//!
//! The current pulses: its mean square over an interval in which the voltage is constant follows
//! from its values at both ends and its mean. With the time constant `t` of the winding and the
//! steady current `s = mean - (start - end) t/T`
//!
//! ```text
//! i = s + (start - s) exp(-time/t)
//! mean square = s^2 + 2 s (mean - s) + ((start - s)^2 - (end - s)^2) t/(2 T)
//! ```

use super::BoardPlantOptions;
use crate::parameter::ParameterError;

/// At this temperature the resistance is that of the parameters, deg C.
const COLD_DEG_C: f64 = 25.0;

/// The resistance follows the temperature in steps of this size, K: 0.1 % of copper.
const STEP_K: f64 = 0.25;

crate::parameters! {
    /// Thermal resistances and time constants of the motor. Data sheets of motors of 16 to 22 mm
    /// state 6 to 10 K/W and 5 to 10 s of the winding, 20 to 40 K/W and 200 to 500 s of the
    /// housing.
    pub struct HeatParameters {
        /// From the winding to the housing.
        winding_housing_k_w [""]: 8.0, "K/W", 0.1, 1000.0, "estimate";
        /// From the housing to the air.
        housing_ambient_k_w [""]: 30.0, "K/W", 0.1, 1000.0, "estimate";
        /// Time constant of the winding against the housing.
        winding_time_s [""]: 10.0, "s", 0.1, 10e3, "estimate";
        /// Time constant of the housing against the air.
        housing_time_s [""]: 300.0, "s", 1.0, 100e3, "estimate";
        /// Rise of the resistance.
        copper_per_k [""]: 0.0, "1/K", 0.0, 0.01, "constant resistance; copper 0.0039";
    }
}

/// The temperatures.
#[derive(Debug, Clone)]
pub(super) struct Heat {
    parameters: HeatParameters,
    /// Resistance of the cold winding.
    resistance_ohm: f64,
    winding_deg_c: f64,
    housing_deg_c: f64,
    /// Square of the current over the interval so far, A^2 s.
    square_a2_s: f64,
    /// Heat of the winding since the start, J.
    copper_j: f64,
    /// The temperature of the present resistance.
    applied_deg_c: f64,
}

impl Heat {
    pub fn try_new(options: &BoardPlantOptions) -> Result<Self, ParameterError> {
        options.heat.check()?;
        Ok(Self {
            parameters: options.heat,
            resistance_ohm: options.drivetrain.electrical.winding_resistance_ohm,
            winding_deg_c: options.ambient_deg_c,
            housing_deg_c: options.ambient_deg_c,
            square_a2_s: 0.0,
            copper_j: 0.0,
            applied_deg_c: COLD_DEG_C,
        })
    }

    /// Takes the current of an interval with a constant voltage: at both ends and in the mean.
    pub fn take(
        &mut self,
        (start_a, end_a, mean_a): (f64, f64, f64),
        constant_s: f64,
        time_s: f64,
    ) {
        let share = constant_s / time_s;
        let steady_a = mean_a - (start_a - end_a) * share;
        let (from_a, to_a) = (start_a - steady_a, end_a - steady_a);
        let square_a2 =
            steady_a * (2.0 * mean_a - steady_a) + (from_a * from_a - to_a * to_a) * share * 0.5;
        self.square_a2_s += square_a2.max(0.0) * time_s;
    }

    /// Ends an interval; returns the resistance, ohm, if it has changed.
    pub fn advance(&mut self, air_deg_c: f64, time_s: f64) -> Option<f64> {
        let p = &self.parameters;
        let heated_j = self.square_a2_s * self.warm_ohm();
        let over_housing_k = self.winding_deg_c - self.housing_deg_c;
        let over_air_k = self.housing_deg_c - air_deg_c;
        let (winding, housing) = (time_s / p.winding_time_s, time_s / p.housing_time_s);
        let gain = p.housing_ambient_k_w / p.winding_housing_k_w;
        self.winding_deg_c +=
            heated_j * p.winding_housing_k_w / p.winding_time_s - over_housing_k * winding;
        self.housing_deg_c += (over_housing_k * gain - over_air_k) * housing;
        self.square_a2_s = 0.0;
        self.copper_j += heated_j;
        let has_changed = (self.winding_deg_c - self.applied_deg_c).abs() > STEP_K;
        if self.parameters.copper_per_k == 0.0 || !has_changed {
            return None;
        }
        self.applied_deg_c = self.winding_deg_c;
        Some(self.warm_ohm())
    }

    fn warm_ohm(&self) -> f64 {
        let warmer_k = self.winding_deg_c - COLD_DEG_C;
        self.resistance_ohm * (1.0 + self.parameters.copper_per_k * warmer_k)
    }

    pub fn winding_deg_c(&self) -> f64 {
        self.winding_deg_c
    }

    pub fn copper_j(&self) -> f64 {
        self.copper_j
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heat(copper_per_k: f64) -> Heat {
        let mut options = BoardPlantOptions::default();
        options.heat.copper_per_k = copper_per_k;
        Heat::try_new(&options).unwrap()
    }

    #[test]
    fn the_mean_square_of_an_exponential_is_exact() {
        // From 0 to 1 A (1 - exp(-3)) in three time constants; the integral of (1 - exp(-x))^2.
        let mut heat = heat(0.0);
        let e = |x: f64| libm::exp(-x);
        let end_a = 1.0 - e(3.0);
        let mean_a = 1.0 - (1.0 - e(3.0)) / 3.0;
        heat.take((0.0, end_a, mean_a), 1e-3, 3e-3);
        let expected = 3.0 - 2.0 * (1.0 - e(3.0)) + 0.5 * (1.0 - e(6.0));
        assert!((heat.square_a2_s / 1e-3 - expected).abs() < 1e-12);
    }

    #[test]
    fn a_constant_current_warms_to_the_steady_state_of_the_warm_copper() {
        let mut heat = heat(0.0039);
        let mut resistance_ohm = 7.7;
        for _ in 0..300_000 {
            heat.take((0.4, 0.4, 0.4), 1e-4, 0.01);
            resistance_ohm = heat.advance(25.0, 0.01).unwrap_or(resistance_ohm);
        }
        // w = P (Rwh + Rha)/(1 - a P (Rwh + Rha)), P = 0.16 * 7.7 W.
        let cold_k = 0.16 * 7.7 * 38.0;
        let expected_k = cold_k / (1.0 - 0.0039 * cold_k);
        assert!((heat.winding_deg_c() - 25.0 - expected_k).abs() < 0.1);
        let expected_ohm = 7.7 * (1.0 + 0.0039 * expected_k);
        assert!((resistance_ohm - expected_ohm).abs() < 7.7 * 0.0039 * STEP_K * 1.5);
    }
}
