//! Computes the gains of the board for a motor and a target bandwidth.
//!
//! The zero of the PI controller of the rate loop cancels the pole of the motor (paper, section
//! II.B): with `Kp = w tau/K` and `Ki = w/K` the rate loop is `w/s` with the bandwidth `w`, and the
//! position gain `P` is a fraction of `w`. The resulting loop of the board, with sampling, rate
//! filter and delay, is computed exactly; warnings report insufficient margins.

mod code;
mod figure;
mod search;
mod warning;

pub use code::{Language, code};
pub use figure::{bode, stable_margins};
pub use warning::{LEAST_GAIN_MARGIN_DB, LEAST_PHASE_MARGIN_DEG, Warning};

use crate::analysis::frequency::bandwidth_hz;
use crate::analysis::linear_models::{Loop, Motor, Timing};
use crate::analysis::loop_gain::Margins;
use crate::analysis::robustness::unstable_motor;
use model_core::control::{encoder_word::COUNT_DEG, parameters::ControlParameters};
use model_core::parameter::ParameterError;

model_core::parameters! {
    /// A target bandwidth of the rate loop and a position gain relative to it, as in the paper.
    pub struct InnerLoop {
        /// Bandwidth of the rate loop, `w`.
        inner_bandwidth_rad_s ["w"]: 28.36, "rad/s", 1e-3, 1e4, "paper: F G = 28.36/s";
        /// Position gain as a fraction of it, `P/w`: a quarter gives critical damping.
        position_share [""]: 8.0 / 28.36, "1", 1e-3, 10.0, "paper: P = 8 beside 28.36";
    }
}

model_core::parameters! {
    /// A target bandwidth and phase margin of the position loop.
    pub struct PositionLoop {
        /// Bandwidth from position command to angle.
        bandwidth_hz [""]: 1.646, "Hz", 1e-2, 1e3, "the default loop on the board";
        /// Minimum phase margin of the sampled loop, opened at the duty.
        phase_margin_deg [""]: 57.0, "deg", 0.0, 90.0, "the default loop on the board";
    }
}

model_core::parameters! {
    /// The tolerated effect of the encoder quantization on the duty.
    pub struct Ripple {
        /// Largest change of the duty for one encoder count without a warning.
        duty_jump_limit_pct [""]: 20.0, "%", 0.0, 100.0, "estimate: a fifth of the bridge";
    }
}

/// The design goal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Goal {
    /// The rate loop is specified.
    Inner(InnerLoop),
    /// The position loop is specified. Of the gains that meet the goal, the smallest are selected.
    Position(PositionLoop),
}

/// The input of [`tune`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TuneRequest {
    /// The motor. For an asymmetric motor, use the direction with the larger gain: it is less
    /// stable.
    pub motor: Motor,
    /// Sampling and delay of the board.
    pub timing: Timing,
    /// The other parameters of the board, for example rate filter and feed-forward.
    pub control: ControlParameters,
    /// The design goal.
    pub goal: Goal,
    /// The tolerated effect of the encoder quantization.
    pub ripple: Ripple,
}

impl Default for TuneRequest {
    fn default() -> Self {
        Self {
            motor: Motor::default(),
            timing: Timing::default(),
            control: ControlParameters::default(),
            goal: Goal::Inner(InnerLoop::default()),
            ripple: Ripple::default(),
        }
    }
}

/// Gains and the properties of the resulting loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Tuning {
    /// The parameters of the request with the new gains.
    pub control: ControlParameters,
    /// Bandwidth of the continuous rate loop, rad/s.
    pub inner_bandwidth_rad_s: f64,
    /// Margins of the sampled loop, opened at the duty.
    pub margins: Margins,
    /// Bandwidth of the sampled loop from command to angle, Hz. `None` if the gain does not fall to
    /// half power below the Nyquist frequency.
    pub bandwidth_hz: Option<f64>,
    /// Change of the duty when the angle changes by one encoder count, %.
    pub duty_jump_pct: f64,
    /// The warnings, most severe first.
    pub warnings: Vec<Warning>,
}

/// Why no gains could be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TuneError {
    /// A given or computed parameter is NaN or out of range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// No gains within their ranges give a stable loop with this bandwidth.
    #[error(
        "bandwidth_hz is {target_hz}, expected at most {maximum_hz:.3} Hz: no stable loop of this \
         motor and timing with gains in their ranges is faster"
    )]
    BandwidthOutOfReach {
        /// The target, Hz.
        target_hz: f64,
        /// The maximum, Hz.
        maximum_hz: f64,
    },
}

/// Computes the gains for a request.
///
/// ```
/// use host_sim::tune::{TuneRequest, tune};
/// // The paper's motor, a rate loop of 28.36 rad/s and P = 8: Kp = 1.318, Ki = 10.
/// let tuning = tune(&TuneRequest::default()).unwrap();
/// assert!((tuning.control.proportional_gain - 1.318).abs() < 1e-3);
/// assert!((tuning.control.integral_gain - 10.0).abs() < 1e-9);
/// assert!(tuning.warnings.is_empty());
/// ```
///
/// # Errors
/// [`TuneError`] for a given or computed parameter that is out of range, and for a bandwidth that
/// cannot be reached.
pub fn tune(request: &TuneRequest) -> Result<Tuning, TuneError> {
    request.ripple.check()?;
    let (inner_bandwidth_rad_s, share, target_phase_deg) = match &request.goal {
        Goal::Inner(goal) => {
            goal.check()?;
            (goal.inner_bandwidth_rad_s, goal.position_share, 0.0)
        }
        Goal::Position(goal) => {
            goal.check()?;
            let (inner_bandwidth_rad_s, share) = search::position_loop(request, goal)?;
            (inner_bandwidth_rad_s, share, goal.phase_margin_deg)
        }
    };
    let control = request.gains(inner_bandwidth_rad_s, share);
    let servo = Loop::sampled(&request.motor, &control, &request.timing)?;
    let margins = Margins::of(&servo);
    let unstable_motor = unstable_motor(&request.motor, &control, &request.timing)?;
    let duty_jump_pct = duty_jump_pct(&control, &request.timing);
    Ok(Tuning {
        control,
        inner_bandwidth_rad_s,
        margins,
        bandwidth_hz: bandwidth_hz(&servo.closed),
        duty_jump_pct,
        warnings: warning::list(
            &margins,
            unstable_motor,
            target_phase_deg,
            duty_jump_pct,
            &request.ripple,
        ),
    })
}

impl TuneRequest {
    /// The parameters of the board with gains that cancel the motor's pole.
    fn gains(&self, inner_bandwidth_rad_s: f64, share: f64) -> ControlParameters {
        let tau = self.motor.motor_time_constant_s;
        let integral_gain = inner_bandwidth_rad_s / self.motor.motor_gain;
        ControlParameters {
            position_gain: share * inner_bandwidth_rad_s,
            proportional_gain: integral_gain * tau,
            integral_gain,
            // 1/Ti, the external-reset form. Above 1/T the forward Euler integration overshoots.
            anti_windup_gain: 1.0 / tau.max(self.timing.control_period_s),
            ..self.control
        }
    }
}

/// The change of the duty in the control step in which the angle changes by one count: through
/// position gain, filtered difference and feed-forward.
fn duty_jump_pct(control: &ControlParameters, timing: &Timing) -> f64 {
    let difference = control.rate_filter / timing.control_period_s;
    let position = control.position_gain;
    COUNT_DEG
        * (control.proportional_gain * (position + difference)
            + control.feed_forward_gain * position)
}

#[cfg(test)]
mod tests;
