//! Inputs designed for an actuator: timing from its bandwidth, amplitude from its rate limit.

use std::f64::consts::TAU;

use model_core::{excitation::catalogue::Input, parameter::ParameterError};

use super::{Designed, ExperimentSetup};
use crate::problem::IdentifyError;

/// Constraints of the inputs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// The bandwidth of the actuator, Hz, which determines the timing.
    pub bandwidth_hz: f64,
    /// Largest command, deg.
    pub most_deg: f64,
}

/// Target share of the time at the rate limit, of an input that exceeds it.
const BEYOND_SHARE: f64 = 0.25;
/// The same of an input within the limit: no sample may reach it.
const WITHIN_SHARE: f64 = 0.0;
/// Margin of an input within the limit, because the rate is higher between two samples.
const WITHIN_MARGIN: f64 = 0.9;
/// Bisections of the amplitude: to 0.1 %.
const HALVINGS: usize = 10;

/// The bandwidth according to a model's parameters, Hz; the 4.775 Hz of the paper where no
/// parameter determines it.
pub fn bandwidth_hz(setup: &ExperimentSetup) -> f64 {
    let value = |name: &str| {
        let index = setup.model.parameter_index(name)?;
        Some(setup.values[index]).filter(|v| v.is_finite() && *v > 0.0)
    };
    let rad_s = value("pole_rad_s")
        .or_else(|| value("natural_frequency_rad_s"))
        .or_else(|| Some(value("position_gain_per_s2")?.sqrt()))
        .or_else(|| value("position_gain"));
    rad_s.unwrap_or(30.0) / TAU
}

/// The input of this name, timed for a bandwidth, with an amplitude of 1 deg.
///
/// Doublet and 3-2-1-1 have the units of P. Marchand of Jategaonkar (chapter 2): 2.3 and
/// 2.1 over the natural frequency. Chirp, multisine and PRBS are strong up to twice the bandwidth.
///
/// # Errors
/// Those of [`Input::set`] for a duration or a bandwidth that no input can have.
pub fn timed(
    name: &str,
    bandwidth_hz: f64,
    duration_s: f64,
) -> Option<Result<Input, ParameterError>> {
    let mut input = Input::named(name)?;
    let rad_s = TAU * bandwidth_hz;
    let settings: Vec<(&str, f64)> = match input {
        Input::Pulse(_) => vec![("start_s", 0.1 * duration_s), ("end_s", 0.55 * duration_s)],
        Input::Doublet(_) => vec![("start_s", 0.1 * duration_s), ("unit_s", 2.3 / rad_s)],
        Input::ThreeTwoOneOne(_) => vec![("start_s", 0.1 * duration_s), ("unit_s", 2.1 / rad_s)],
        Input::VariableStep(_) => vec![("dwell_s", duration_s / 15.0)],
        Input::Ramp(_) => vec![
            ("hold_s", 0.1 * duration_s),
            ("rate_deg_s", 5.0 / duration_s),
        ],
        Input::Chirp(_) | Input::LogChirp(_) => vec![
            ("start_hz", 0.05 * bandwidth_hz),
            ("end_hz", 2.0 * bandwidth_hz),
            ("duration_s", duration_s),
        ],
        Input::Sine(_) => vec![("frequency_hz", 0.7 * bandwidth_hz)],
        Input::Prbs(_) => prbs(bandwidth_hz, duration_s),
        // Odd lines up to the 39th, at twice the bandwidth.
        Input::Multisine(_) => vec![("base_hz", 2.0 * bandwidth_hz / 39.0), ("lines", 20.0)],
    };
    let scale = if matches!(input, Input::VariableStep(_)) {
        "scale"
    } else {
        "amplitude_deg"
    };
    let set = settings.into_iter().chain([(scale, 1.0)]);
    let set = set
        .into_iter()
        .try_for_each(|(name, value)| input.set(name, value));
    Some(set.map(|()| input))
}

/// A chip for the bandwidth, and an order whose period fills the experiment once.
fn prbs(bandwidth_hz: f64, duration_s: f64) -> Vec<(&'static str, f64)> {
    let chip_s = 0.22 / bandwidth_hz;
    let order = (duration_s / chip_s + 1.0).log2().floor().clamp(3.0, 16.0);
    vec![("chip_s", chip_s), ("order", order)]
}

/// Designs an input with the largest amplitude within the rate limit, or with one that exceeds it
/// on purpose, up to the largest command. `None` for an unknown input.
///
/// # Errors
/// Those of [`timed`] and of [`ExperimentSetup::predict`], in words.
pub fn design(
    setup: &ExperimentSetup,
    name: &str,
    limits: &Limits,
    is_beyond: bool,
) -> Option<Result<Designed, String>> {
    let input = timed(name, limits.bandwidth_hz, setup.duration_s)?;
    Some(
        input
            .map_err(|e| e.to_string())
            .and_then(|input| scaled(setup, input, limits, is_beyond)),
    )
}

fn scaled(
    setup: &ExperimentSetup,
    mut input: Input,
    limits: &Limits,
    is_beyond: bool,
) -> Result<Designed, String> {
    let message = |error: IdentifyError| error.to_string();
    let excitation = input.excitation().map_err(|error| error.to_string())?;
    let unit = setup.command(&excitation);
    let peak = unit.iter().fold(0.0, |peak: f64, c| peak.max(c.abs()));
    if peak == 0.0 {
        return Err("the input does not move within the experiment".into());
    }
    let share_of = |amplitude: f64| {
        let command: Vec<f64> = unit.iter().map(|c| c * amplitude / peak).collect();
        setup.limited_share(&command).map_err(message)
    };
    let target_share = if is_beyond {
        BEYOND_SHARE
    } else {
        WITHIN_SHARE
    };
    let (mut low, mut high) = (0.0, limits.most_deg);
    let mut amplitude_deg = high;
    if share_of(high)? > target_share {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if share_of(middle)? > target_share {
                high = middle;
            } else {
                low = middle;
            }
        }
        amplitude_deg = if is_beyond { high } else { WITHIN_MARGIN * low };
    }
    if amplitude_deg == 0.0 {
        return Err("no amplitude stays within the rate limit".into());
    }
    let scale = if matches!(input, Input::VariableStep(_)) {
        "scale"
    } else {
        "amplitude_deg"
    };
    let factor = amplitude_deg / peak;
    input
        .set(scale, factor)
        .map_err(|error| error.to_string())?;
    if matches!(input, Input::Ramp(_)) {
        // A ramp of another height with the same duration.
        let rate = 5.0 / setup.duration_s * factor;
        input
            .set("rate_deg_s", rate)
            .map_err(|error| error.to_string())?;
    }
    let excitation = input.excitation().map_err(|error| error.to_string())?;
    let command_deg = setup.command(&excitation);
    let prediction = setup.predict(&command_deg).map_err(message)?;
    Ok(Designed {
        input,
        is_beyond,
        amplitude_deg,
        command_deg,
        prediction,
    })
}

/// The index of the design that identifies the most parameters, and among these the one with the
/// smallest worst error.
pub fn best(designs: &[Designed]) -> Option<usize> {
    let most = designs.iter().map(|d| d.prediction.identified()).max()?;
    let candidates = (0..designs.len()).filter(|&i| designs[i].prediction.identified() == most);
    let worst = |i: &usize| designs[*i].prediction.worst_percent();
    candidates.min_by(|a, b| worst(a).total_cmp(&worst(b)))
}
