//! The response of a model to inputs, at the steps of a target.

use std::sync::Arc;

use model_core::actuator::{Actuator, Settings};
use model_core::excitation::catalogue::Input;
use model_core::parameter::ParameterError;
use model_core::time::seconds;

/// The response of a model.
pub(super) struct Response {
    /// What the actuator is to reach, at each step, deg: command, gain and offset of the model.
    pub target_deg: Arc<[f64]>,
    /// The angle at each step, deg.
    pub angle_deg: Vec<f64>,
    /// The greatest magnitude of the command, deg.
    pub amplitude_deg: f64,
}

impl Response {
    /// Simulates a model whose command changes at the steps of the target only, on one input after
    /// the other.
    pub fn of(settings: &Settings, inputs: &[Input], step_s: f64) -> Result<Self, ParameterError> {
        let mut actuator = Actuator::try_new(settings)?;
        let (gain, offset_deg) = steady(settings);
        let (mut target_deg, mut angle_deg) = (Vec::new(), Vec::new());
        let (mut command_deg, mut next_s) = (0.0, 0.0);
        let (mut before_deg, mut amplitude_deg) = (0.0, 0.0_f64);
        let mut start = 0;
        for input in inputs {
            let excitation = input.excitation()?;
            let duration = input.duration_ticks()?;
            for tick in 0..duration {
                let (now_s, now_deg) = (seconds(start + tick), actuator.reading().angle_deg);
                // Within a billionth of a tick.
                if now_s >= next_s - 1e-13 {
                    command_deg = excitation.command(tick).to_f64();
                    amplitude_deg = amplitude_deg.max(command_deg.abs());
                    target_deg.push(gain * command_deg + offset_deg);
                    let since = (now_s - next_s) / seconds(1);
                    angle_deg.push(now_deg + since * (before_deg - now_deg));
                    next_s = target_deg.len() as f64 * step_s;
                }
                before_deg = now_deg;
                // A command of the excitation is always finite.
                let _ = actuator.advance(command_deg, 1);
            }
            start += duration;
        }
        Ok(Self {
            target_deg: target_deg.into(),
            angle_deg,
            amplitude_deg,
        })
    }

    /// The standard deviation of the angle, deg.
    pub fn spread_deg(&self) -> f64 {
        let count = self.angle_deg.len() as f64;
        let mean = self.angle_deg.iter().sum::<f64>() / count;
        let squares = self.angle_deg.iter().map(|angle| (angle - mean).powi(2));
        (squares.sum::<f64>() / count).sqrt()
    }
}

/// Gain and offset, deg, between command and steady angle.
pub(super) fn steady(settings: &Settings) -> (f64, f64) {
    let value = |name| value(settings, name);
    (
        value("gain").unwrap_or(1.0),
        value("offset_deg").unwrap_or(0.0),
    )
}

/// A parameter of a model by name; `None` where it has no such parameter.
pub(super) fn value(settings: &Settings, name: &str) -> Option<f64> {
    let mut values = settings.values();
    Some(values.find(|v| v.parameter.name == name)?.value)
}
