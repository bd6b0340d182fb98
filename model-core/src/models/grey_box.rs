//! The paper's grey box (section III.C): motor, rate PI with anti-windup and position P.
//!
//! ```text
//! r  = P (c - theta)            ws = sat(w, -rdn, rup)            e = r - ws
//! v  = Kp e + x                 u  = sat(v, -umax, umax)
//! x' = Ki e + Kaw (u - v) + Kawr (ws - w)
//! w' = (K(u) u - w)/tau         K(u) = Kup for u > 0, Kdn otherwise
//! theta' = ws, limited to +-pos
//! ```
//!
//! in continuous time, with a Runge-Kutta step of one tick. The defaults are the consistent reading
//! of equations (1) and (2); [`crate::presets`] contains the others.
//!
//! The paper describes the anti-windup as "a gain to offset the accumulated error in the integral"
//! and prints no number: it can act on the duty limit (Kaw) and on the rate limit (Kawr).

use super::{ActuatorModel, Output, rk4};
use crate::limits::{hard_stop, within};
use crate::parameter::ParameterError;
use crate::time::TICK_S;

crate::parameters! {
    /// Parameters of the grey box.
    ///
    /// The ranges limit each parameter individually. In addition, the pole of the rate loop, `K
    /// Kp/tau`, must remain below 2.7 per tick, 54,000 rad/s, for the Runge-Kutta step to be
    /// stable; the default is 28 rad/s.
    pub struct GreyBoxParameters {
        /// Steady rate per duty for positive duty.
        motor_gain_up ["Kup"]: 2.836, "(deg/s)/%", 0.0, 1000.0, "paper, eq. (2), read as G(s) = 2.836/(1 + 0.1318 s)";
        /// Steady rate per duty for negative duty.
        motor_gain_down ["Kdn"]: 2.836, "(deg/s)/%", 0.0, 1000.0, "paper, eq. (2), read as G(s) = 2.836/(1 + 0.1318 s)";
        /// Time constant of the rate.
        motor_time_constant_s ["tau"]: 1.0 / 7.586, "s", 1e-4, 100.0, "paper, eq. (2): pole at 7.586 rad/s";
        /// Proportional gain of the rate loop.
        proportional_gain ["Kp"]: 10.0 / 7.586, "%/(deg/s)", 0.0, 1000.0, "paper, eq. (1), read as F(s) = 10 (1 + 0.1318 s)/s";
        /// Integral gain of the rate loop.
        integral_gain ["Ki"]: 10.0, "%/deg", 0.0, 1e5, "paper, eq. (1), read as F(s) = 10 (1 + 0.1318 s)/s";
        /// Gain of the position loop.
        position_gain ["P"]: 8.0, "1/s", 0.0, 10_000.0, "paper, section II.B: outer loop gain of eight";
        /// Gain of the anti-windup by back-calculation from the duty limit.
        anti_windup_gain ["Kaw"]: 7.586, "1/s", 0.0, 10_000.0, "1/Ti, the external-reset form; the paper prints none";
        /// Gain of the anti-windup by back-calculation from the rate limit.
        rate_anti_windup_gain ["Kawr"]: 0.0, "%/deg", 0.0, 10_000.0, "none; the paper prints no anti-windup number";
        /// Maximum magnitude of the duty.
        duty_limit_pct ["umax"]: 100.0, "%", 0.0, f64::INFINITY, "the whole bridge";
        /// Maximum rate in positive direction.
        rate_limit_up_deg_s ["rup"]: f64::INFINITY, "deg/s", 0.0, f64::INFINITY, "none beyond the duty limit";
        /// Maximum rate in negative direction.
        rate_limit_down_deg_s ["rdn"]: f64::INFINITY, "deg/s", 0.0, f64::INFINITY, "none beyond the duty limit";
        /// Hard stops at plus and minus this angle.
        position_limit_deg ["pos"]: 180.0, "deg", 0.0, f64::INFINITY, "paper, section III.A: deflection limit of 180 degrees";
    }
}

/// The grey box.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GreyBox {
    #[cfg_attr(feature = "serde", serde(with = "crate::parameter::as_values"))]
    parameters: GreyBoxParameters,
    angle_deg: f64,
    /// Motor rate before the limit.
    rate_deg_s: f64,
    /// Integrator of the rate loop.
    integral_pct: f64,
}

/// What the grey box is commanded in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Demand {
    /// Angle, deg: both loops are closed.
    Angle(f64),
    /// Rate, deg/s: the rate loop alone is closed.
    Rate(f64),
    /// Duty, %, up to its limit: both loops are open and the integrator is empty.
    Duty(f64),
}

/// Output of the controller.
pub struct Control {
    /// Rate after the limit, `ws`.
    pub limited_rate_deg_s: f64,
    /// Rate error, `e`.
    pub error_deg_s: f64,
    /// Duty before the limit, `v`.
    pub demand_pct: f64,
    /// Duty, `u`.
    pub duty_pct: f64,
}

impl GreyBox {
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
    /// use model_core::models::{ActuatorModel, grey_box::GreyBox};
    ///
    /// let model = GreyBox::try_new(Default::default()).unwrap();
    /// // Kp P = 10.55 %/deg.
    /// assert!((model.output(1.0).duty_pct - 10.0 / 7.586 * 8.0).abs() < 1e-12);
    /// assert_eq!(model.output(90.0).duty_pct, 100.0);
    /// ```
    pub fn try_new(parameters: GreyBoxParameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        Ok(Self {
            parameters,
            angle_deg: 0.0,
            rate_deg_s: 0.0,
            integral_pct: 0.0,
        })
    }

    /// Its parameters.
    pub fn parameters(&self) -> &GreyBoxParameters {
        &self.parameters
    }

    /// Angle, deg, motor rate before the limit, deg/s, and integrator of the rate loop, %.
    pub(crate) fn state(&self) -> [f64; 3] {
        [self.angle_deg, self.rate_deg_s, self.integral_pct]
    }

    /// Sets all three.
    pub(crate) fn set_state(&mut self, [angle_deg, rate_deg_s, integral_pct]: [f64; 3]) {
        (self.angle_deg, self.rate_deg_s) = (angle_deg, rate_deg_s);
        self.integral_pct = integral_pct;
    }

    /// Changes the parameters, under this demand without a jump of the duty unless its limit
    /// changes: the integrator takes the difference.
    ///
    /// # Errors
    /// As [`Self::try_new`]; nothing is changed then.
    pub fn retune(
        &mut self,
        parameters: GreyBoxParameters,
        demand: Demand,
    ) -> Result<(), ParameterError> {
        parameters.check()?;
        let before = self.parameters.control(demand, self.state()).demand_pct;
        let after = parameters.control(demand, self.state()).demand_pct;
        self.parameters = parameters;
        if !matches!(demand, Demand::Duty(_)) {
            self.integral_pct += before - after;
        }
        Ok(())
    }
}

impl GreyBoxParameters {
    /// The controller's output at an angle, a rate and an integrator.
    #[inline]
    pub fn control(&self, command: Demand, [angle, rate, integral]: [f64; 3]) -> Control {
        let limited_rate_deg_s =
            within(rate, -self.rate_limit_down_deg_s, self.rate_limit_up_deg_s);
        let rate_command_deg_s = match command {
            Demand::Angle(command_deg) => self.position_gain * (command_deg - angle),
            Demand::Rate(rate_deg_s) => rate_deg_s,
            Demand::Duty(duty_pct) => {
                let duty_pct = within(duty_pct, -self.duty_limit_pct, self.duty_limit_pct);
                return Control {
                    limited_rate_deg_s,
                    error_deg_s: 0.0,
                    demand_pct: duty_pct,
                    duty_pct,
                };
            }
        };
        let error_deg_s = rate_command_deg_s - limited_rate_deg_s;
        let demand_pct = self.proportional_gain * error_deg_s + integral;
        Control {
            limited_rate_deg_s,
            error_deg_s,
            demand_pct,
            duty_pct: within(demand_pct, -self.duty_limit_pct, self.duty_limit_pct),
        }
    }

    /// Derivative of angle, rate and integrator.
    #[inline]
    pub fn derivative(&self, command: Demand, state: [f64; 3]) -> [f64; 3] {
        let [_, rate, _] = state;
        let control = self.control(command, state);
        let motor_gain = if control.duty_pct > 0.0 {
            self.motor_gain_up
        } else {
            self.motor_gain_down
        };
        [
            control.limited_rate_deg_s,
            (motor_gain * control.duty_pct - rate) / self.motor_time_constant_s,
            self.integral_gain * control.error_deg_s
                + self.anti_windup_gain * (control.duty_pct - control.demand_pct)
                + self.rate_anti_windup_gain * (control.limited_rate_deg_s - rate),
        ]
    }
}

impl GreyBox {
    /// As [`ActuatorModel::output`].
    pub fn output_for(&self, demand: Demand) -> Output {
        let control = self.parameters.control(demand, self.state());
        Output {
            angle_deg: self.angle_deg,
            rate_deg_s: control.limited_rate_deg_s,
            duty_pct: control.duty_pct,
        }
    }

    /// As [`ActuatorModel::advance_tick`].
    #[inline]
    pub fn step_for(&mut self, demand: Demand) {
        if let Demand::Duty(_) = demand {
            self.integral_pct = 0.0;
        }
        let p = &self.parameters;
        let [angle, rate, integral] =
            rk4::step(self.state(), TICK_S, |state| p.derivative(demand, state));
        (self.angle_deg, self.rate_deg_s) = hard_stop(angle, rate, p.position_limit_deg);
        self.integral_pct = integral;
    }
}

impl ActuatorModel for GreyBox {
    fn output(&self, command_deg: f64) -> Output {
        self.output_for(Demand::Angle(command_deg))
    }

    #[inline]
    fn advance_tick(&mut self, command_deg: f64) {
        self.step_for(Demand::Angle(command_deg));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::tests::angle_after;
    use crate::parameter::Parameters;

    fn model(set: &[(&str, f64)]) -> GreyBox {
        let mut parameters = GreyBoxParameters::default();
        for (name, value) in set {
            parameters.set(name, *value).unwrap();
        }
        GreyBox::try_new(parameters).unwrap()
    }

    #[test]
    fn a_rate_limit_is_reached_exactly() {
        let mut model = model(&[("rup", 100.0), ("rdn", 150.0)]);
        for (command_deg, rate_deg_s) in [(90.0, 100.0), (-90.0, -150.0)] {
            angle_after(&mut model, command_deg, 10_000);
            assert_eq!(model.output(command_deg).rate_deg_s, rate_deg_s);
        }
    }

    #[test]
    fn the_hard_stop_sets_the_rate_to_zero() {
        let mut model = model(&[]);
        assert_eq!(angle_after(&mut model, 300.0, 40_000), 180.0);
        assert_eq!(model.output(300.0).rate_deg_s, 0.0);
        assert!(angle_after(&mut model, 0.0, 1) <= 180.0);
        assert_eq!(angle_after(&mut model, -300.0, 60_000), -180.0);
    }

    #[test]
    fn gains_change_without_a_jump_of_the_duty_and_act_from_then_on() {
        let mut model = model(&[]);
        angle_after(&mut model, 2.0, 1000);
        let before = model.output(2.0);
        let slow = GreyBoxParameters {
            position_gain: 3.0,
            proportional_gain: 0.4,
            ..Default::default()
        };
        model.retune(slow, Demand::Angle(2.0)).unwrap();
        let after = model.output(2.0);
        assert!((after.duty_pct - before.duty_pct).abs() < 1e-12);
        assert_eq!(after.angle_deg, before.angle_deg);
        // A degree more of command is P Kp more duty.
        let step_pct = model.output(3.0).duty_pct - after.duty_pct;
        assert!((step_pct - 3.0 * 0.4).abs() < 1e-12, "{step_pct}");
        let unstable = GreyBoxParameters {
            position_gain: -1.0,
            ..slow
        };
        assert!(model.retune(unstable, Demand::Angle(2.0)).is_err());
        assert_eq!(model.output(2.0), after);
    }

    #[test]
    fn anti_windup_from_the_duty_limit_shortens_the_overshoot() {
        let highest = |anti_windup_gain| {
            let mut model = model(&[("Kaw", anti_windup_gain)]);
            (0..40_000).fold(0.0_f64, |top, _| top.max(angle_after(&mut model, 90.0, 1)))
        };
        assert!(highest(7.586) < 90.5, "{}", highest(7.586));
        assert!(highest(0.0) > 95.0, "{}", highest(0.0));
    }
}
