//! Warnings about margins that are below the request or below customary values.

use super::Ripple;
use crate::analysis::loop_gain::Margins;
use crate::analysis::robustness::{Ratios, SPREAD};
use std::fmt;

/// Smallest phase margin without a warning, deg: the lower end of the customary 45 to 60 degrees.
pub const LEAST_PHASE_MARGIN_DEG: f64 = 45.0;

/// Smallest gain margin without a warning, dB: the customary factor of two.
pub const LEAST_GAIN_MARGIN_DB: f64 = 6.0;

/// A warning about a tuning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Warning {
    /// The closed loop is not stable.
    Unstable,
    /// The closed loop is not stable with another motor of the box.
    Spread(Ratios),
    /// The phase margin is small.
    PhaseMargin {
        /// The margin, deg.
        value_deg: f64,
        /// The expected minimum, deg.
        expected_deg: f64,
    },
    /// The gain margin is small.
    GainMargin {
        /// The margin, dB; negative if a lower gain makes the loop unstable.
        value_db: f64,
    },
    /// One encoder count changes the duty by too much.
    DutyJump {
        /// The change, %.
        value_pct: f64,
        /// The expected maximum, %.
        expected_pct: f64,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unstable => write!(f, "the sampled loop is unstable"),
            Self::Spread(Ratios { gain, pole }) => write!(
                f,
                "the sampled loop is unstable for a motor with {gain:.2} times the steady-state rate \
                 and {pole:.2} times the pole: expected stability while gain, pole, supply and \
                 inertia are within {:.0} %",
                100.0 * SPREAD
            ),
            Self::PhaseMargin {
                value_deg,
                expected_deg,
            } => write!(
                f,
                "the phase margin is {value_deg:.1} deg, expected at least {expected_deg} deg"
            ),
            Self::GainMargin { value_db } => write!(
                f,
                "the gain margin is {value_db:.1} dB, expected at least {LEAST_GAIN_MARGIN_DB} dB \
                 either way"
            ),
            Self::DutyJump {
                value_pct,
                expected_pct,
            } => write!(
                f,
                "one encoder count moves the duty by {value_pct:.1} %, expected at most \
                 {expected_pct} %: filter the rate more or lower the bandwidth"
            ),
        }
    }
}

/// The warnings, most severe first. Margins of an unstable loop have no meaning and are omitted.
pub(super) fn list(
    margins: &Margins,
    unstable_motor: Option<Ratios>,
    target_phase_deg: f64,
    duty_jump_pct: f64,
    ripple: &Ripple,
) -> Vec<Warning> {
    let phase_deg = margins.phase_deg.map(|m| m.value);
    let gain_db = margins.gain_db.map(|m| m.value);
    let expected_deg = target_phase_deg.max(LEAST_PHASE_MARGIN_DEG);
    let small_phase = phase_deg.filter(|p| margins.stable && p.abs() < expected_deg);
    let small_gain = gain_db.filter(|g| margins.stable && g.abs() < LEAST_GAIN_MARGIN_DB);
    let far = duty_jump_pct > ripple.duty_jump_limit_pct;
    let warnings = [
        (!margins.stable).then_some(Warning::Unstable),
        (unstable_motor.filter(|_| margins.stable)).map(Warning::Spread),
        small_phase.map(|value_deg| Warning::PhaseMargin {
            value_deg,
            expected_deg,
        }),
        small_gain.map(|value_db| Warning::GainMargin { value_db }),
        far.then_some(Warning::DutyJump {
            value_pct: duty_jump_pct,
            expected_pct: ripple.duty_jump_limit_pct,
        }),
    ];
    warnings.into_iter().flatten().collect()
}
