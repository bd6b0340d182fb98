//! The paper's first-order black box (section III.A): one pole between two saturations.
//!
//! `theta' = sat(p (gain c + offset - theta), -rdn, rup)`, `theta` limited to `+-pos`, with a
//! Runge-Kutta step of one tick. Gain and offset are 1 and 0 in the paper; identification estimates
//! them. The rate limits apply by the sign of the rate.

use super::{ActuatorModel, Output, rk4};
use crate::limits::within;
use crate::parameter::ParameterError;
use crate::time::TICK_S;

crate::parameters! {
    /// Parameters of the first-order black box.
    pub struct BlackBox1Parameters {
        // 10,000 rad/s is half a radian per tick; the Runge-Kutta step is stable up to 2.78.
        /// Pole of the position loop, the paper's "gain".
        pole_rad_s ["p"]: 30.0, "rad/s", 0.0, 10_000.0, "paper, section III.A: 30 rad/s, 4.78 Hz";
        /// Steady angle per commanded angle.
        gain [""]: 1.0, "1", -100.0, 100.0, "none in the paper";
        /// Steady angle at a command of zero.
        offset_deg [""]: 0.0, "deg", -32000.0, 32000.0, "none in the paper";
        /// Maximum rate in positive direction.
        rate_limit_up_deg_s ["rup"]: 240.0, "deg/s", 0.0, f64::INFINITY, "paper, section III.A: 240 deg/s approaching the step";
        /// Maximum rate in negative direction.
        rate_limit_down_deg_s ["rdn"]: 350.0, "deg/s", 0.0, f64::INFINITY, "paper, section III.A: -350 deg/s leaving the step";
        /// Hard stops at plus and minus this angle.
        position_limit_deg ["pos"]: 180.0, "deg", 0.0, f64::INFINITY, "paper, section III.A: deflection limit of 180 degrees";
    }
}

/// The first-order black box.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BlackBox1 {
    #[cfg_attr(feature = "serde", serde(with = "crate::parameter::as_values"))]
    parameters: BlackBox1Parameters,
    angle_deg: f64,
}

impl BlackBox1 {
    /// The angle, deg.
    pub(crate) fn angle_deg(&self) -> f64 {
        self.angle_deg
    }

    /// Sets the angle, deg.
    pub(crate) fn place(&mut self, angle_deg: f64) {
        self.angle_deg = angle_deg;
    }

    /// A model with these parameters, at angle zero.
    ///
    /// # Errors
    /// Names the first parameter that is NaN or outside its range.
    ///
    /// ```
    /// use model_core::models::{ActuatorModel, black_box_1::BlackBox1};
    ///
    /// let mut model = BlackBox1::try_new(Default::default()).unwrap();
    /// for _ in 0..200 {
    ///     model.advance_tick(90.0);
    /// }
    /// // 10 ms at the limit of 240 deg/s.
    /// assert!((model.output(90.0).angle_deg - 2.4).abs() < 1e-12);
    /// ```
    pub fn try_new(parameters: BlackBox1Parameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        Ok(Self {
            parameters,
            angle_deg: 0.0,
        })
    }
}

impl BlackBox1Parameters {
    /// Steady angle for a command.
    #[inline]
    pub fn target_deg(&self, command_deg: f64) -> f64 {
        self.gain * command_deg + self.offset_deg
    }

    /// Rate at an angle before its limits, for a target.
    #[inline]
    pub fn unlimited_rate_deg_s(&self, target_deg: f64, angle_deg: f64) -> f64 {
        self.pole_rad_s * (target_deg - angle_deg)
    }

    /// Rate at an angle, for a target.
    #[inline]
    pub fn rate_deg_s(&self, target_deg: f64, angle_deg: f64) -> f64 {
        within(
            self.unlimited_rate_deg_s(target_deg, angle_deg),
            -self.rate_limit_down_deg_s,
            self.rate_limit_up_deg_s,
        )
    }
}

impl ActuatorModel for BlackBox1 {
    fn output(&self, command_deg: f64) -> Output {
        let target_deg = self.parameters.target_deg(command_deg);
        Output {
            angle_deg: self.angle_deg,
            rate_deg_s: self.parameters.rate_deg_s(target_deg, self.angle_deg),
            duty_pct: 0.0,
        }
    }

    #[inline]
    fn advance_tick(&mut self, command_deg: f64) {
        let p = &self.parameters;
        let target_deg = p.target_deg(command_deg);
        let [angle_deg] = rk4::step([self.angle_deg], TICK_S, |[angle_deg]| {
            [p.rate_deg_s(target_deg, angle_deg)]
        });
        self.angle_deg = within(angle_deg, -p.position_limit_deg, p.position_limit_deg);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::tests::angle_after;
    use crate::parameter::Parameters;

    fn model(set: &[(&str, f64)]) -> BlackBox1 {
        let mut parameters = BlackBox1Parameters::default();
        for (name, value) in set {
            parameters.set(name, *value).unwrap();
        }
        BlackBox1::try_new(parameters).unwrap()
    }

    #[test]
    fn the_position_limit_is_reached_exactly_and_left_at_once() {
        let mut model = model(&[]);
        assert_eq!(angle_after(&mut model, 300.0, 20_000), 180.0);
        assert!(angle_after(&mut model, 0.0, 1) < 180.0);
        assert_eq!(angle_after(&mut model, -300.0, 40_000), -180.0);
    }

    #[test]
    fn gain_and_offset_set_the_steady_angle() {
        let mut model = model(&[("gain", -0.5), ("offset_deg", 3.0)]);
        // After 30 time constants 1e-13 of the step remains.
        assert!((angle_after(&mut model, 10.0, 20_000) + 2.0).abs() < 1e-10);
    }

    #[test]
    fn a_parameter_outside_its_range_is_refused() {
        let parameters = BlackBox1Parameters {
            pole_rad_s: f64::NAN,
            ..Default::default()
        };
        assert!(BlackBox1::try_new(parameters).is_err());
    }
}
