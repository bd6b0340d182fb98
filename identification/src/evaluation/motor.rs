//! Unloaded motors with random parameters, of which only ratios are observable.

use model_core::sensors::noise::Noise;

use super::fault::uniform;
use super::system::response;
use crate::experiment::Experiment;
use crate::recording::Recording;

/// Steps of the duty, %, of half a second each.
const LEVELS_PCT: [f64; 8] = [60.0, -40.0, 15.0, -70.0, 30.0, 0.0, 80.0, -20.0];

/// The response of a motor with a known resistance to steps of the duty, at 250 Hz, and its
/// parameters.
pub fn unloaded(noise: &mut Noise) -> Option<(Recording, Vec<(&'static str, f64)>)> {
    let truth = vec![
        ("torque_constant_nm_a", uniform(noise, 0.2, 0.8)),
        ("motor_inertia_kg_m2", uniform(noise, 0.004, 0.02)),
        ("viscous_friction_nm_s_deg", uniform(noise, 5e-5, 3e-4)),
        ("coulomb_friction_nm", uniform(noise, 0.01, 0.05)),
        ("delay_s", uniform(noise, 0.005, 0.02)),
    ];
    let time_s: Vec<f64> = (0..1000).map(|i| 0.004 * f64::from(i)).collect();
    let mut recording = Recording {
        name: "unloaded".into(),
        command_deg: vec![0.0; time_s.len()],
        // A placeholder: the check requires an angle that varies.
        angle_deg: time_s.clone(),
        duty_pct: Some((0..time_s.len()).map(|i| LEVELS_PCT[i / 125]).collect()),
        constants: [
            ("winding_resistance_ohm".to_owned(), 5.0),
            ("supply_v".to_owned(), 12.0),
        ]
        .into(),
        time_s,
        ..Recording::default()
    };
    let run = Experiment::try_new(recording.clone()).ok()?;
    recording.angle_deg = response("motor-m1", &truth, &run)?;
    Some((recording, truth))
}
