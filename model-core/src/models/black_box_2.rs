//! The paper's second-order black box (section III.B): two nested gains and two integrators.
//!
//! `w' = A (gain c + offset - theta) - B w`, `theta' = w`, with `w` limited to `-rdn..=rup` and
//! `theta` limited to `+-pos`, with a Runge-Kutta step of one tick. With A = 900 and B = 54 the
//! natural frequency is 30 rad/s (4.775 Hz) and the damping 0.9; the -3 dB bandwidth is 3.56 Hz.
//! The paper does not state where in the block diagram the rate is limited: see [`RateLimitForm`].

use super::{ActuatorModel, Output, rk4};
use crate::limits::{hard_stop, within};
use crate::parameter::ParameterError;
use crate::time::TICK_S;

crate::parameters! {
    /// Parameters of the second-order black box.
    pub struct BlackBox2Parameters {
        // 1e8 is a natural frequency of 10,000 rad/s, half a radian per tick; the Runge-Kutta step
        // is stable up to 2.78 on both axes.
        /// Gain of the outer loop.
        position_gain_per_s2 ["A"]: 900.0, "1/s^2", 0.0, 1e8, "paper, section III.B: outer loop gain of 900";
        /// Gain of the inner loop.
        rate_gain_per_s ["B"]: 54.0, "1/s", 0.0, 10_000.0, "paper, section III.B: inner loop gain of 54";
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
        /// Location of the rate limit: 0 in the integrator, 1 and 2 after it, with the limited (1)
        /// or the unlimited rate (2) fed back.
        rate_limit_form ["bb2_sat"]: 0.0, "choice", 0.0, 2.0, "a limited integrator does not wind up; the paper does not say";
    }
}

/// Location of the rate limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RateLimitForm {
    /// The integrator of the rate stops at its limits.
    LimitedIntegrator,
    /// A saturation follows the integrator, which winds up; the limited rate is fed back.
    LimitedFeedback,
    /// A saturation follows the integrator; the unlimited rate is fed back.
    UnlimitedFeedback,
}

/// The second-order black box.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BlackBox2 {
    #[cfg_attr(feature = "serde", serde(with = "crate::parameter::as_values"))]
    parameters: BlackBox2Parameters,
    form: RateLimitForm,
    angle_deg: f64,
    /// State of the rate integrator, before any saturation after it.
    rate_deg_s: f64,
}

impl BlackBox2 {
    /// Angle, deg, and state of the rate integrator, deg/s.
    pub(crate) fn state(&self) -> [f64; 2] {
        [self.angle_deg, self.rate_deg_s]
    }

    /// Sets both.
    pub(crate) fn set_state(&mut self, [angle_deg, rate_deg_s]: [f64; 2]) {
        (self.angle_deg, self.rate_deg_s) = (angle_deg, rate_deg_s);
    }

    /// Sets the angle, deg.
    pub(crate) fn place(&mut self, angle_deg: f64) {
        self.angle_deg = angle_deg;
    }

    /// The model with these parameters, at rest at zero.
    ///
    /// # Errors
    /// Names the first parameter that is NaN or outside its range.
    ///
    /// ```
    /// use model_core::models::{ActuatorModel, black_box_2::BlackBox2};
    ///
    /// let mut model = BlackBox2::try_new(Default::default()).unwrap();
    /// for _ in 0..20_000 {
    ///     model.advance_tick(90.0);
    /// }
    /// assert!((model.output(90.0).angle_deg - 90.0).abs() < 1e-3);
    /// ```
    pub fn try_new(parameters: BlackBox2Parameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        Ok(Self {
            parameters,
            form: parameters.form(),
            angle_deg: 0.0,
            rate_deg_s: 0.0,
        })
    }
}

impl BlackBox2Parameters {
    /// The selected form; the range of the parameter is checked in `try_new`.
    pub fn form(&self) -> RateLimitForm {
        match self.rate_limit_form {
            0.0 => RateLimitForm::LimitedIntegrator,
            1.0 => RateLimitForm::LimitedFeedback,
            _ => RateLimitForm::UnlimitedFeedback,
        }
    }

    /// The rate after its limits.
    #[inline]
    pub fn limited(&self, rate_deg_s: f64) -> f64 {
        within(
            rate_deg_s,
            -self.rate_limit_down_deg_s,
            self.rate_limit_up_deg_s,
        )
    }

    /// Derivative of angle and rate.
    #[inline]
    pub fn derivative(
        &self,
        form: RateLimitForm,
        target_deg: f64,
        [angle, rate]: [f64; 2],
    ) -> [f64; 2] {
        let limited = self.limited(rate);
        let fed_back = if form == RateLimitForm::UnlimitedFeedback {
            rate
        } else {
            limited
        };
        let acceleration =
            self.position_gain_per_s2 * (target_deg - angle) - self.rate_gain_per_s * fed_back;
        let outward = (rate >= self.rate_limit_up_deg_s && acceleration > 0.0)
            || (rate <= -self.rate_limit_down_deg_s && acceleration < 0.0);
        if form == RateLimitForm::LimitedIntegrator && outward {
            [limited, 0.0]
        } else {
            [limited, acceleration]
        }
    }
}

impl ActuatorModel for BlackBox2 {
    fn output(&self, _command_deg: f64) -> Output {
        Output {
            angle_deg: self.angle_deg,
            rate_deg_s: self.parameters.limited(self.rate_deg_s),
            duty_pct: 0.0,
        }
    }

    #[inline]
    fn advance_tick(&mut self, command_deg: f64) {
        let (p, form) = (&self.parameters, self.form);
        let target_deg = p.gain * command_deg + p.offset_deg;
        let [angle, mut rate] = rk4::step([self.angle_deg, self.rate_deg_s], TICK_S, |state| {
            p.derivative(form, target_deg, state)
        });
        if form == RateLimitForm::LimitedIntegrator {
            rate = p.limited(rate);
        }
        (self.angle_deg, self.rate_deg_s) = hard_stop(angle, rate, p.position_limit_deg);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::tests::angle_after;
    use crate::parameter::Parameters;

    fn model(set: &[(&str, f64)]) -> BlackBox2 {
        let mut parameters = BlackBox2Parameters::default();
        for (name, value) in set {
            parameters.set(name, *value).unwrap();
        }
        BlackBox2::try_new(parameters).unwrap()
    }

    #[test]
    fn both_rate_limits_are_reached_exactly_in_every_form() {
        for form in [0.0, 1.0, 2.0] {
            let mut model = model(&[("bb2_sat", form)]);
            angle_after(&mut model, 170.0, 2000);
            assert_eq!(model.output(170.0).rate_deg_s, 240.0);
            angle_after(&mut model, -170.0, 4000);
            assert_eq!(model.output(-170.0).rate_deg_s, -350.0);
        }
    }

    #[test]
    fn a_limited_integrator_overshoots_less_than_one_that_winds_up() {
        let highest = |form| {
            let mut model = model(&[("bb2_sat", form)]);
            (0..20_000).fold(0.0_f64, |top, _| top.max(angle_after(&mut model, 90.0, 1)))
        };
        // Damping 0.9 alone overshoots by 0.15 %, 0.14 deg.
        assert!(highest(0.0) < 90.14, "{}", highest(0.0));
        assert!(highest(1.0) > 95.0, "{}", highest(1.0));
    }

    #[test]
    fn the_hard_stop_sets_the_rate_to_zero() {
        let mut model = model(&[]);
        assert_eq!(angle_after(&mut model, 300.0, 20_000), 180.0);
        assert_eq!(model.output(300.0).rate_deg_s, 0.0);
        // The motion away from the stop starts from rest: w = -A 180 h + O(h^2) after a tick.
        model.advance_tick(0.0);
        let rate = model.output(0.0).rate_deg_s;
        assert!((rate + 900.0 * 180.0 * TICK_S).abs() < 0.02, "{rate}");
        assert_eq!(angle_after(&mut model, -300.0, 40_000), -180.0);
        assert_eq!(model.output(-300.0).rate_deg_s, 0.0);
    }

    #[test]
    fn gain_and_offset_set_the_steady_angle() {
        let mut model = model(&[("gain", -0.5), ("offset_deg", 3.0)]);
        // exp(-27 t) is 2e-12 after a second.
        assert!((angle_after(&mut model, 10.0, 20_000) + 2.0).abs() < 1e-9);
    }

    #[test]
    fn a_fractional_rate_limit_form_is_refused() {
        let parameters = BlackBox2Parameters {
            rate_limit_form: 0.5,
            ..Default::default()
        };
        assert!(matches!(
            BlackBox2::try_new(parameters),
            Err(ParameterError::OutOfRange { parameter, .. }) if parameter.symbol == "bb2_sat"
        ));
    }
}
