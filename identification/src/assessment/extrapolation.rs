//! Held-out recordings that go beyond the fitted ones: their predictions extrapolate.

use std::collections::BTreeMap;

use crate::experiment::Experiment;
use crate::start::{DataSummary, greatest_angle_deg};

/// Ratio to the greatest fitted value from which a recording goes beyond it.
const BEYOND: f64 = 1.1;

/// Standard gravity, m/s^2.
const GRAVITY_M_S2: f64 = 9.806_65;

/// A warning for each held-out recording that goes beyond the fitted ones.
pub fn warnings(fitted: &[Experiment], held_out: &[Experiment]) -> Vec<String> {
    let mut greatest: BTreeMap<&'static str, f64> = BTreeMap::new();
    for run in fitted.iter().flat_map(|run| extent(run)) {
        let value = greatest.entry(run.0).or_insert(0.0);
        *value = value.max(run.1);
    }
    let warning = |run: &Experiment| {
        let beyond = extent(run).into_iter().filter_map(|(what, value)| {
            let known = *greatest.get(what)?;
            (value > BEYOND * known).then(|| format!("{what} of {value:.4} against {known:.4}"))
        });
        let beyond: Vec<String> = beyond.collect();
        (!beyond.is_empty()).then(|| {
            format!(
                "{} goes beyond the fitted recordings, its prediction is an extrapolation: {}",
                run.recording.name,
                beyond.join(", ")
            )
        })
    };
    held_out.iter().filter_map(warning).collect()
}

/// How far a recording goes.
fn extent(run: &Experiment) -> Vec<(&'static str, f64)> {
    let data = DataSummary::of(std::slice::from_ref(run));
    let constant = |name: &str| run.recording.constants.get(name).copied();
    let mut extent = vec![(
        "a rate (deg/s)",
        data.rate_up_deg_s.max(data.rate_down_deg_s),
    )];
    if let Some(gain) = constant("firmware_gain") {
        extent.push(("a gain of the position loop", gain));
    }
    let load = constant("pendulum_mass_kg").zip(constant("pendulum_length_m"));
    if let Some((mass_kg, length_m)) = load {
        let angle_deg = greatest_angle_deg(std::slice::from_ref(run)).min(90.0);
        let torque_nm = mass_kg * GRAVITY_M_S2 * length_m * angle_deg.to_radians().sin();
        extent.push(("a load torque (Nm)", torque_nm));
    }
    extent
}
