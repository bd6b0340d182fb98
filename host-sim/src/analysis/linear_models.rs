//! The models without limits, as transfer functions from command to angle.
//!
//! Position controller P around rate controller PI. The loop is opened at the duty:
//!
//! ```text
//! C = Kp + Ki/x    H = a x/(T x + a)    x = (z - 1)/T, or s where T = 0
//! open   = G (C (P + H) + Kff P)        closed = G P (C + Kff)/(1 + open)
//! ```
//!
//! The integrator is forward Euler and `H` is the filtered encoder difference, exactly as on the
//! board. `G` is the motor from duty to angle, `K/(s (tau s + 1))`; its sampled form is exact for a
//! duty that is held and takes effect a delay after the samples. The grey box is the limit of the
//! board for a period of zero. Anti-windup and limits have no effect on small signals.

use super::polynomial::Polynomial;
use super::transfer_function::TransferFunction;
use model_core::control::parameters::ControlParameters;
use model_core::parameter::{Parameter, ParameterError, Parameters};
use model_core::plant::first_order::FirstOrderParameters;
use model_core::time::{CONTROL_PERIOD_S, UPDATE_RATE_HZ};

model_core::parameters! {
    /// The motor for one direction of rotation.
    pub struct Motor {
        /// Steady-state rate per duty.
        motor_gain ["K"]: 2.836, "(deg/s)/%", 1e-6, 1000.0, "paper, eq. (2), read as G(s) = 2.836/(1 + 0.1318 s)";
        /// Time constant of the rate.
        motor_time_constant_s ["tau"]: 1.0 / 7.586, "s", 1e-4, 100.0, "paper, eq. (2): pole at 7.586 rad/s";
    }
}

impl Motor {
    /// The motor for positive rates.
    ///
    /// ```
    /// use host_sim::analysis::linear_models::Motor;
    /// assert_eq!(Motor::upward(&Default::default()).motor_gain, 2.836);
    /// ```
    pub fn upward(plant: &FirstOrderParameters) -> Self {
        Self {
            motor_gain: plant.motor_gain_up,
            motor_time_constant_s: plant.motor_time_constant_s,
        }
    }

    /// The motor for negative rates.
    ///
    /// ```
    /// use host_sim::analysis::linear_models::Motor;
    /// assert_eq!(Motor::downward(&Default::default()).motor_gain, 2.836);
    /// ```
    pub fn downward(plant: &FirstOrderParameters) -> Self {
        Self {
            motor_gain: plant.motor_gain_down,
            ..Self::upward(plant)
        }
    }
}

model_core::parameters! {
    /// The timing of the board.
    pub struct Timing {
        /// Control period.
        control_period_s ["T"]: CONTROL_PERIOD_S, "s", 1e-4, 0.1, "that of the board; paper, section II.A";
        /// Time from the sampling of the angle to the change of the duty.
        duty_delay_s [""]: 1.0 / UPDATE_RATE_HZ as f64, "s", 0.0, 0.8, "the next edge of the PWM; at most 8 control periods";
    }
}

/// Largest delay of the duty, in control periods. It limits the degree of the polynomials.
pub const MAX_DELAY_PERIODS: f64 = 8.0;

/// Black box 1, `p/(s + p)` (paper, section III.A).
///
/// ```
/// let model = host_sim::analysis::linear_models::black_box_1(30.0);
/// assert_eq!(model.steady_gain(), 1.0);
/// ```
pub fn black_box_1(pole_rad_s: f64) -> TransferFunction {
    TransferFunction::continuous(
        Polynomial::new([pole_rad_s]),
        Polynomial::new([pole_rad_s, 1.0]),
    )
}

/// Black box 2, `A/(s^2 + B s + A)` (paper, section III.B).
///
/// ```
/// use host_sim::analysis::{frequency::bandwidth_hz, linear_models::black_box_2};
/// let model = black_box_2(900.0, 54.0);
/// assert!((bandwidth_hz(&model).unwrap() - 3.562).abs() < 1e-3);
/// ```
pub fn black_box_2(position_gain_per_s2: f64, rate_gain_per_s: f64) -> TransferFunction {
    TransferFunction::continuous(
        Polynomial::new([position_gain_per_s2]),
        Polynomial::new([position_gain_per_s2, rate_gain_per_s, 1.0]),
    )
}

/// The open and the closed loop of the position servo.
#[derive(Debug, Clone, PartialEq)]
pub struct Loop {
    /// The loop opened at the duty, without the minus sign of the feedback.
    pub open: TransferFunction,
    /// From position command to angle, without the transport delay of the test set-up.
    pub closed: TransferFunction,
}

impl Loop {
    /// The grey box (paper, section III.C): continuous, with feedback of the true rate.
    ///
    /// ```
    /// use host_sim::analysis::{frequency::bandwidth_hz, linear_models::Loop};
    /// let grey = Loop::continuous(&Default::default(), &Default::default()).unwrap();
    /// assert!((bandwidth_hz(&grey.closed).unwrap() - 1.680).abs() < 1e-3);
    /// ```
    ///
    /// # Errors
    /// A parameter that is NaN or out of range.
    pub fn continuous(motor: &Motor, control: &ControlParameters) -> Result<Self, ParameterError> {
        motor.check()?;
        control.check()?;
        let numerator = Polynomial::new([motor.motor_gain]);
        let denominator = Polynomial::new([0.0, 1.0, motor.motor_time_constant_s]);
        Ok(Self::around(&numerator, &denominator, control, 0.0))
    }

    /// The board: sampled with `timing.control_period_s`, with delayed and held duty and the rate
    /// from the filtered encoder difference. The angle is that at the control steps.
    ///
    /// ```
    /// use host_sim::analysis::{frequency::bandwidth_hz, linear_models::Loop};
    /// let defaults = (Default::default(), Default::default(), Default::default());
    /// let board = Loop::sampled(&defaults.0, &defaults.1, &defaults.2).unwrap();
    /// assert!((bandwidth_hz(&board.closed).unwrap() - 1.646).abs() < 1e-3);
    /// ```
    ///
    /// # Errors
    /// A parameter that is NaN or out of range, and a delay of more than
    /// [`MAX_DELAY_PERIODS`].
    pub fn sampled(
        motor: &Motor,
        control: &ControlParameters,
        timing: &Timing,
    ) -> Result<Self, ParameterError> {
        motor.check()?;
        control.check()?;
        timing.check()?;
        delay_limit(timing.control_period_s).check(timing.duty_delay_s)?;
        let (numerator, denominator) = sampled_motor(motor, timing);
        let period_s = timing.control_period_s;
        Ok(Self::around(&numerator, &denominator, control, period_s))
    }

    /// The loop of the controller with a motor from duty to angle.
    fn around(
        motor_numerator: &Polynomial,
        motor_denominator: &Polynomial,
        control: &ControlParameters,
        period_s: f64,
    ) -> Self {
        let scalar = |value: f64| Polynomial::new([value]);
        let position_gain = scalar(control.position_gain);
        let feed_forward = scalar(control.feed_forward_gain);
        let (pi, pi_denominator) = if control.integral_gain == 0.0 {
            // Without an input the integrator is not part of the loop.
            (scalar(control.proportional_gain), scalar(1.0))
        } else {
            let gains = [control.integral_gain, control.proportional_gain];
            (Polynomial::new(gains), Polynomial::new([0.0, 1.0]))
        };
        let rate = Polynomial::new([0.0, control.rate_filter]);
        let rate_denominator = Polynomial::new([control.rate_filter, period_s]);

        let forward = &pi + &(&feed_forward * &pi_denominator);
        let forward = &(&forward * &position_gain) * &rate_denominator;
        let once_around = &forward + &(&pi * &rate);
        let denominator = &(motor_denominator * &pi_denominator) * &rate_denominator;
        let open = TransferFunction::sampled(motor_numerator * &once_around, denominator, period_s);
        let closed = TransferFunction::closing(&open, motor_numerator * &forward);
        Self { open, closed }
    }
}

/// The parameter of the delay, with a maximum that depends on the control period.
fn delay_limit(control_period_s: f64) -> Parameter {
    Parameter {
        max: MAX_DELAY_PERIODS * control_period_s,
        ..Timing::TABLE[1]
    }
}

/// The motor from delayed and held duty to sampled angle, as polynomials in `x = (z - 1)/T`.
///
/// With `E = 1 - exp(-T/tau)`, `m` the remainder of the period after the delay, and
/// `g(t) = t - tau (1 - exp(-t/tau))` the angle after `t` for unit gain and unit duty:
///
/// ```text
///         E/T + (g(T) + E m)/T x + g(m) x^2
/// G = K ------------------------------------
///           x (x + E/T) (1 + T x)^(n + 1)
/// ```
///
/// which is the transform of the step response `g(k T - delay)`. `n` is the number of whole periods
/// in the delay.
fn sampled_motor(motor: &Motor, timing: &Timing) -> (Polynomial, Polynomial) {
    let tau = motor.motor_time_constant_s;
    let period = timing.control_period_s;
    let whole_periods = (timing.duty_delay_s / period).floor();
    let m = period - (timing.duty_delay_s - whole_periods * period);
    let share = -(-period / tau).exp_m1();
    let g = |t: f64| t + tau * (-t / tau).exp_m1();

    let numerator = [share / period, (g(period) + share * m) / period, g(m)];
    let poles = Polynomial::new([0.0, share / period, 1.0]);
    let late = Polynomial::new([1.0, period]).power(whole_periods as usize + 1);
    let gain = Polynomial::new([motor.motor_gain]);
    (&gain * &Polynomial::new(numerator), &poles * &late)
}

#[cfg(test)]
#[path = "linear_models_tests.rs"]
mod tests;
