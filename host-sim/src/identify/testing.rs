//! Recordings with a known truth, for tests.

use model_core::control::encoder_word::COUNT_DEG;
use model_core::excitation::catalogue::Input;
use model_core::sensors::noise::Noise;

use super::recording::Recording;
use crate::input::Command;
use crate::settings::{ModelKind, PlantKind, Settings};
use crate::simulate::Simulation;

/// What the simulator makes of an input, as a recording with a row of every `every`th tick.
pub fn simulated(kind: ModelKind, input: &str, every: u64, set: &[(&str, f64)]) -> Recording {
    let mut settings = Settings::new(kind, PlantKind::FirstOrder);
    for (name, value) in set {
        settings
            .set(name, *value)
            .expect("a parameter of the model");
    }
    let input = Input::named(input).expect("an input");
    let trace = Simulation {
        settings,
        command: Command::Excitation(input.excitation().expect("it is in range")),
        input: input.name().into(),
        load: None,
        ticks: input.duration_ticks().expect("it is in range"),
        every,
    }
    .record()
    .expect("a run");
    let column = |name| trace.column(name).expect("a column").to_vec();
    Recording {
        name: input.name().into(),
        time_s: column("t"),
        command_deg: column("command"),
        angle_deg: column("angle_deg"),
        ..Default::default()
    }
}

/// The same with noise of 0.05 deg and the 12 bits of the encoder.
pub fn noisy(mut recording: Recording, seed: u64) -> Recording {
    let mut noise = Noise::new(seed, 0);
    for angle in &mut recording.angle_deg {
        *angle = ((*angle + noise.gaussian(0.05)) / COUNT_DEG).round() * COUNT_DEG;
    }
    recording
}
