//! Simulated recordings with known parameters, and the noise and resolution of an encoder.

use model_core::actuator::{Actuator, ModelKind, PlantKind, Settings};
use model_core::control::encoder_word::COUNT_DEG;
use model_core::excitation::catalogue::Input;
use model_core::parameter::ParameterError;
use model_core::sensors::noise::Noise;
use model_core::time::seconds;

use super::recording::Recording;

/// Noise of the angle, deg.
pub const NOISE_DEG: f64 = 0.05;

/// Simulates a model on a standard input, with a sample at every `every`th tick.
///
/// ```
/// use identification::synthetic::simulated;
/// use model_core::actuator::ModelKind;
///
/// let pulse = simulated(ModelKind::BlackBox1, "pulse", 80, &[("pole_rad_s", 20.0)])?;
/// assert_eq!(pulse.len(), 1250);
/// # Ok::<(), model_core::parameter::ParameterError>(())
/// ```
///
/// # Errors
/// [`ParameterError`] for an unknown input or parameter, a value out of range, or parameters that
/// contradict each other.
pub fn simulated(
    model: ModelKind,
    input: &str,
    every: u64,
    set: &[(&str, f64)],
) -> Result<Recording, ParameterError> {
    let mut settings = Settings::new(model, PlantKind::FirstOrder);
    for (name, value) in set {
        settings.set(name, *value)?;
    }
    let mut actuator = Actuator::try_new(&settings)?;
    let input = Input::named(input).ok_or(ParameterError::Unknown)?;
    let excitation = input.excitation()?;
    let mut recording = Recording {
        name: input.name().into(),
        ..Default::default()
    };
    for tick in 0..input.duration_ticks()? {
        let command_deg = excitation.command(tick).to_f64();
        if tick.is_multiple_of(every) {
            recording.time_s.push(seconds(tick));
            recording.command_deg.push(command_deg);
            recording.angle_deg.push(actuator.reading().angle_deg);
        }
        // A command of the excitation is always finite.
        let _ = actuator.advance(command_deg, 1);
    }
    Ok(recording)
}

/// The same with noise of [`NOISE_DEG`] and the 12 bits of the encoder.
pub fn noisy(mut recording: Recording, seed: u64) -> Recording {
    let mut noise = Noise::new(seed, 0);
    for angle in &mut recording.angle_deg {
        *angle = ((*angle + noise.gaussian(NOISE_DEG)) / COUNT_DEG).round() * COUNT_DEG;
    }
    recording
}
