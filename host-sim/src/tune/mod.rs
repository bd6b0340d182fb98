//! From a motor and a wish to the gains of the board.
//!
//! The rate loop cancels the motor's pole with the zero of its PI (paper, section II.B): with
//! `Kp = w tau/K` and `Ki = w/K` the loop is `w/s` around the rate, `w` its bandwidth, and the
//! position gain `P` is a share of `w`. The board samples, filters and is late; what it makes of
//! these gains is computed exactly and reported, with a warning where it falls short.

mod search;
mod warning;

pub use warning::{LEAST_GAIN_MARGIN_DB, LEAST_PHASE_MARGIN_DEG, Warning};

use crate::analysis::frequency::bandwidth_hz;
use crate::analysis::linear_models::{Loop, Motor, Timing};
use crate::analysis::loop_gain::Margins;
use model_core::control::parameters::ControlParameters;
use model_core::parameter::ParameterError;

/// Angle of one encoder count, deg: 12 bits a turn (AS5045).
const COUNT_DEG: f64 = 360.0 / 4096.0;

model_core::parameters! {
    /// A rate loop of wanted bandwidth, and a position loop beside it: the paper's way.
    pub struct InnerLoop {
        /// Bandwidth of the rate loop, `w`.
        inner_bandwidth_rad_s ["w"]: 28.36, "rad/s", 1e-3, 1e4, "paper: F G = 28.36/s";
        /// Position gain as a share of it, `P/w`: a quarter is critical damping.
        position_share [""]: 8.0 / 28.36, "1", 1e-3, 10.0, "paper: P = 8 beside 28.36";
    }
}

model_core::parameters! {
    /// A position loop of wanted bandwidth and phase margin.
    pub struct PositionLoop {
        /// Bandwidth from position command to angle.
        bandwidth_hz [""]: 1.646, "Hz", 1e-2, 1e3, "the default loop on the board";
        /// Least phase margin of the sampled loop, cut at the duty.
        phase_margin_deg [""]: 57.0, "deg", 0.0, 90.0, "the default loop on the board";
    }
}

model_core::parameters! {
    /// What the duty may suffer from the encoder.
    pub struct Ripple {
        /// Greatest jump of the duty for one encoder count that passes without a warning.
        duty_jump_limit_pct [""]: 20.0, "%", 0.0, 100.0, "estimate: a fifth of the bridge";
    }
}

/// What the gains are to reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Goal {
    /// The rate loop is given.
    Inner(InnerLoop),
    /// The position loop is given; of the gains that reach it, the smallest are taken.
    Position(PositionLoop),
}

/// All that tuning starts from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// The motor; of an asymmetric one, the sense with the greater gain is the less stable.
    pub motor: Motor,
    /// Sampling and delay of the board.
    pub timing: Timing,
    /// The other parameters of the board, its rate filter and feed-forward among them.
    pub control: ControlParameters,
    /// What is wanted.
    pub goal: Goal,
    /// What the encoder may do to the duty.
    pub ripple: Ripple,
}

impl Default for Request {
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

/// Gains, and what the board makes of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Tuning {
    /// The request's parameters of the board with the new gains.
    pub control: ControlParameters,
    /// Bandwidth of the rate loop before it is sampled, rad/s.
    pub inner_bandwidth_rad_s: f64,
    /// Margins of the sampled loop, cut at the duty.
    pub margins: Margins,
    /// Bandwidth of the sampled loop from command to angle, Hz; `None` where it reaches the
    /// Nyquist frequency.
    pub bandwidth_hz: Option<f64>,
    /// Jump of the duty when the angle moves by one encoder count, %.
    pub duty_jump_pct: f64,
    /// Where it falls short, worst first.
    pub warnings: Vec<Warning>,
}

/// Why there are no gains.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TuneError {
    /// A parameter, given or found, is NaN or outside its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// No gains within their range give this bandwidth in a stable loop.
    #[error(
        "bandwidth_hz is {wanted_hz}, expected at most {greatest_hz:.3} Hz: no stable loop of this \
         motor and timing with gains in their range is faster"
    )]
    BandwidthOutOfReach {
        /// What was wanted, Hz.
        wanted_hz: f64,
        /// The most there is, Hz.
        greatest_hz: f64,
    },
}

/// Finds the gains for a request.
///
/// ```
/// use host_sim::tune::{Request, tune};
/// // The paper's motor, 28.36 rad/s inside and P = 8 outside: Kp = 1.318, Ki = 10.
/// let tuning = tune(&Request::default()).unwrap();
/// assert!((tuning.control.proportional_gain - 1.318).abs() < 1e-3);
/// assert!((tuning.control.integral_gain - 10.0).abs() < 1e-9);
/// assert!(tuning.warnings.is_empty());
/// ```
///
/// # Errors
/// [`TuneError`] for a parameter outside its range, be it given or the outcome, and for a bandwidth
/// out of reach. Lesser shortcomings are warnings.
pub fn tune(request: &Request) -> Result<Tuning, TuneError> {
    request.ripple.check()?;
    let (inner_bandwidth_rad_s, share, wanted_phase_deg) = match &request.goal {
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
    let duty_jump_pct = duty_jump_pct(&control, &request.timing);
    Ok(Tuning {
        control,
        inner_bandwidth_rad_s,
        margins,
        bandwidth_hz: bandwidth_hz(&servo.closed),
        duty_jump_pct,
        warnings: warning::list(&margins, wanted_phase_deg, duty_jump_pct, &request.ripple),
    })
}

impl Request {
    /// The board with gains that cancel the motor's pole.
    fn gains(&self, inner_bandwidth_rad_s: f64, share: f64) -> ControlParameters {
        let tau = self.motor.motor_time_constant_s;
        let integral_gain = inner_bandwidth_rad_s / self.motor.motor_gain;
        ControlParameters {
            position_gain: share * inner_bandwidth_rad_s,
            proportional_gain: integral_gain * tau,
            integral_gain,
            // 1/Ti, the external-reset form. Beyond 1/T forward Euler would overshoot its target.
            anti_windup_gain: 1.0 / tau.max(self.timing.control_period_s),
            ..self.control
        }
    }
}

/// The jump of the duty in the control step that sees the angle one count further: through the
/// position gain, through the filtered difference, and through the feed-forward.
fn duty_jump_pct(control: &ControlParameters, timing: &Timing) -> f64 {
    let difference = control.rate_filter / timing.control_period_s;
    let position = control.position_gain;
    COUNT_DEG
        * (control.proportional_gain * (position + difference)
            + control.feed_forward_gain * position)
}

#[cfg(test)]
mod tests;
