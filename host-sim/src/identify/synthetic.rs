//! Recordings with a known truth: what the simulator makes of an input, and what an encoder shows
//! of it.

use model_core::control::encoder_word::COUNT_DEG;
use model_core::sensors::noise::Noise;

use super::recording::Recording;
use crate::error::Error;
use crate::scenario::{Scenario, Setting};
use crate::settings::ModelKind;

/// Noise of the angle, deg.
pub const NOISE_DEG: f64 = 0.05;

/// What the simulator makes of an input, as a recording with a row of every `every`th tick.
///
/// ```
/// use host_sim::{identify::synthetic::simulated, settings::ModelKind};
///
/// let pulse = simulated(ModelKind::BlackBox1, "pulse", 80, &[("pole_rad_s", 20.0)])?;
/// assert_eq!(pulse.len(), 1250);
/// # Ok::<(), host_sim::error::Error>(())
/// ```
///
/// # Errors
/// For an input or a parameter that is not known, and for parameters that do not go together.
pub fn simulated(
    model: ModelKind,
    input: &str,
    every: u64,
    set: &[(&str, f64)],
) -> Result<Recording, Error> {
    let set = set.iter();
    let scenario = Scenario {
        model: Some(model),
        input: Some(input.into()),
        every: Some(every),
        set: set
            .map(|(name, value)| Setting::new(*name, *value))
            .collect(),
        ..Default::default()
    };
    let trace = scenario.resolve()?.record()?;
    let column = |name| trace.column(name).unwrap_or_default().to_vec();
    Ok(Recording {
        name: input.into(),
        time_s: column("t"),
        command_deg: column("command"),
        angle_deg: column("angle_deg"),
        ..Default::default()
    })
}

/// The same with noise of [`NOISE_DEG`] and the 12 bits of the encoder.
pub fn noisy(mut recording: Recording, seed: u64) -> Recording {
    let mut noise = Noise::new(seed, 0);
    for angle in &mut recording.angle_deg {
        *angle = ((*angle + noise.gaussian(NOISE_DEG)) / COUNT_DEG).round() * COUNT_DEG;
    }
    recording
}
