//! A time-domain simulation of the board's loop in `f64`, by the rules S9 of the project's
//! reference. The tests compare the analysis in the frequency domain with it.

use super::linear_models::{Motor, Timing};
use model_core::control::parameters::ControlParameters;
use model_core::time::{CONTROL_PERIOD_TICKS, TICK_S};

/// An encoder count, deg.
pub const COUNT_DEG: f64 = 360.0 / 4096.0;

/// The board and its motor, with options that simplify the simulation.
#[derive(Default)]
pub struct Board {
    pub motor: Motor,
    pub control: ControlParameters,
    pub timing: Timing,
    /// Without quantization and limits: the linear analysis is exact.
    pub linear: bool,
    /// Factor on the duty, to test a gain margin.
    pub gain: f64,
}

/// The state at every tick: angle, deg, and rate, deg/s.
pub type States = (Vec<f64>, Vec<f64>);

impl Board {
    /// Runs for `ticks` with a command as a function of the tick. The delay is rounded to ticks and
    /// is between one tick and one control period.
    pub fn run(&self, ticks: u64, command_deg: impl Fn(i64) -> f64) -> States {
        let Self { motor, control, .. } = self;
        let period_s = CONTROL_PERIOD_TICKS as f64 * TICK_S;
        let latch = model_core::time::ticks(self.timing.duty_delay_s) % CONTROL_PERIOD_TICKS;
        let tau = motor.motor_time_constant_s;
        let rest = (-TICK_S / tau).exp();
        let (mut angle, mut rate, mut x, mut estimate) = (0.0, 0.0, 0.0, 0.0);
        let (mut last, mut pending, mut duty) = (0.0, 0.0, 0.0);
        let mut states = (Vec::new(), Vec::new());
        for tick in 0..ticks {
            if tick % CONTROL_PERIOD_TICKS == latch {
                duty = pending;
            }
            if tick % CONTROL_PERIOD_TICKS == 0 {
                let measured = self.measured_deg(angle);
                estimate += control.rate_filter * ((measured - last) / period_s - estimate);
                last = measured;
                let rate_command = control.position_gain * (command_deg(tick as i64) - measured);
                let error = rate_command - estimate;
                let v = control.proportional_gain * error
                    + x
                    + control.feed_forward_gain * rate_command;
                let limit = if self.linear {
                    f64::MAX
                } else {
                    control.duty_limit_pct
                };
                let u = v.clamp(-limit, limit);
                x +=
                    period_s * (control.integral_gain * error + control.anti_windup_gain * (u - v));
                pending = u * self.gain;
            }
            states.0.push(angle);
            states.1.push(rate);
            let end = motor.motor_gain * duty;
            angle += end * TICK_S + (rate - end) * tau * (1.0 - rest);
            rate = end + (rate - end) * rest;
        }
        states
    }

    fn measured_deg(&self, angle_deg: f64) -> f64 {
        if self.linear {
            angle_deg
        } else {
            (angle_deg / COUNT_DEG + 0.5).floor() * COUNT_DEG
        }
    }

    /// Whether the linear loop settles after a step: whether its error in the last quarter of
    /// `seconds` is smaller than in the second quarter.
    pub fn settles(&self, seconds: f64) -> bool {
        let ticks = model_core::time::ticks(seconds);
        let (angle, _) = self.run(ticks, |_| 1.0);
        let quarter = angle.len() / 4;
        let largest = |part: &[f64]| part.iter().fold(0.0_f64, |m, a| m.max((a - 1.0).abs()));
        largest(&angle[3 * quarter..]) < largest(&angle[quarter..2 * quarter])
    }
}
