//! Where a tuning falls short of what is wanted, or of what is customary.

use super::Ripple;
use crate::analysis::loop_gain::Margins;
use std::fmt;

/// Least phase margin without a warning, deg: the lower end of the customary 45 to 60 degrees.
pub const LEAST_PHASE_MARGIN_DEG: f64 = 45.0;

/// Least gain margin without a warning, dB: a factor of two, as is customary.
pub const LEAST_GAIN_MARGIN_DB: f64 = 6.0;

/// One shortcoming of a tuning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Warning {
    /// The closed loop is not stable.
    Unstable,
    /// The phase margin is small.
    PhaseMargin {
        /// What there is, deg.
        value_deg: f64,
        /// What was expected, deg.
        expected_deg: f64,
    },
    /// The gain margin is small.
    GainMargin {
        /// What there is, dB; negative where the gain must not fall.
        value_db: f64,
    },
    /// One encoder count moves the duty far.
    DutyJump {
        /// The jump, %.
        value_pct: f64,
        /// What was expected at most, %.
        expected_pct: f64,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unstable => write!(f, "the sampled loop is unstable"),
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

/// The shortcomings, worst first. Margins of an unstable loop are none and are not mentioned.
pub(super) fn list(
    margins: &Margins,
    wanted_phase_deg: f64,
    duty_jump_pct: f64,
    ripple: &Ripple,
) -> Vec<Warning> {
    let phase_deg = margins.phase_deg.map(|m| m.value);
    let gain_db = margins.gain_db.map(|m| m.value);
    let expected_deg = wanted_phase_deg.max(LEAST_PHASE_MARGIN_DEG);
    let small_phase = phase_deg.filter(|p| margins.stable && p.abs() < expected_deg);
    let small_gain = gain_db.filter(|g| margins.stable && g.abs() < LEAST_GAIN_MARGIN_DB);
    let far = duty_jump_pct > ripple.duty_jump_limit_pct;
    let warnings = [
        (!margins.stable).then_some(Warning::Unstable),
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
