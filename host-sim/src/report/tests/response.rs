//! The measured frequency response agrees with the computed one.

use super::super::{bode::undelayed, models::Family, sweep};
use super::*;
use crate::analysis::frequency::{Response, logarithmic_grid};
use model_core::{actuator::Actuator, presets::preset};
use std::f64::consts::TAU;

/// The allowed distance of a measured point from its line, relative to the response, whose gain is
/// `gain`.
fn tolerance(o: &Outcome, frequency_hz: f64, gain: f64) -> f64 {
    // The models in f64 hold the command for a tick: half a tick of delay. The rest is rounding.
    let held = TAU * frequency_hz * 25e-6 + 1e-5;
    // The rounding of the encoder, 0.088 deg/sqrt(12) RMS, relative to the motion.
    let encoder = match o.runs.model.family {
        Family::Board => 0.0254 / (o.runs.model.sweep_amplitude_deg * gain),
        _ => 0.0,
    };
    // Unequal gains: the gain of the fundamental, 2.95 - 0.55^2 x 0.81/2.95 = 2.867 (deg/s)/%, lies
    // 0.7 % above the harmonic mean; the effect on the closed loop is up to twice that.
    let values = preset(o.runs.model.preset).expect("a preset").values;
    let of = |name| values.iter().find(|v| v.0 == name).map(|v| v.1);
    let unequal = match of("motor_gain_up") == of("motor_gain_down") {
        true => 0.0,
        false => 0.014,
    };
    held + encoder + unequal
}

#[test]
fn every_measured_point_agrees_with_its_computed_line() {
    for o in &comparison().outcomes {
        let Some(linear) = &o.linear else {
            continue;
        };
        let measured = undelayed(&o.runs.response, o.runs.settings.setup.delay_s);
        let computed = Response::of(&linear.closed, &measured.frequency_hz);
        for (i, frequency_hz) in measured.frequency_hz.iter().enumerate() {
            let gain_db = measured.gain_db[i] - computed.gain_db[i];
            let phase_deg = measured.phase_deg[i] - computed.phase_deg[i];
            let error = (10_f64.powf(gain_db / 20.0) - 1.0).hypot(phase_deg.to_radians());
            let gain = 10_f64.powf(computed.gain_db[i] / 20.0);
            let tolerance = tolerance(o, *frequency_hz, gain);
            let name = o.runs.model.name;
            assert!(
                error < tolerance,
                "{name}: {error} at {frequency_hz} Hz, not {tolerance}"
            );
        }
    }
}

#[test]
fn the_measured_bandwidth_is_the_computed_one() {
    for o in &comparison().outcomes {
        let found = &o.metrics.small_signal;
        let measured = found.measured_half_power_hz.expect("a crossing");
        if let Some(computed) = found.half_power_hz {
            // Around the crossing the gain falls at least with the 0.7th power of the frequency.
            let tolerance = tolerance(o, measured, 0.7) / 0.7;
            let error = (measured / computed - 1.0).abs();
            assert!(
                error < tolerance,
                "{}: {measured}, not {computed}",
                o.runs.model.name
            );
        }
    }
}

#[test]
fn no_limit_acts_while_the_response_is_measured() {
    for model in &MODELS {
        let settings = model.scenario("sine").settings().expect("a model");
        for frequency_hz in sweep::FREQUENCIES_HZ {
            let mut actuator = Actuator::try_new(&settings).expect("a model");
            let mut largest = (0.0_f64, 0.0_f64);
            let command = sweep::Command::of(model, frequency_hz);
            for tick in 0..2 * command.ticks {
                actuator
                    .advance(command.at(tick), 1)
                    .expect("a finite command");
                let now = actuator.reading();
                largest.0 = largest.0.max(now.rate_deg_s.abs());
                largest.1 = largest.1.max(now.duty_pct.abs());
            }
            assert!(largest.0 < 240.0, "{} at {frequency_hz} Hz", model.name);
            let limited = model.preset != "as-printed";
            assert!(
                !limited || largest.1 < 95.0,
                "{} at {frequency_hz} Hz",
                model.name
            );
        }
    }
}

#[test]
fn the_default_gains_leave_a_resonance_at_24_hz_around_the_motor_as_measured() {
    let linear = outcome("board as-measured")
        .linear
        .as_ref()
        .expect("a line");
    let response = Response::of(&linear.closed, &logarithmic_grid(15.0, 60.0, 500));
    let peak = (0..response.gain_db.len())
        .max_by(|a, b| response.gain_db[*a].total_cmp(&response.gain_db[*b]));
    let at = response.frequency_hz[peak.expect("a grid")];
    assert!((at - 24.0).abs() < 1.0, "{at}");
}
