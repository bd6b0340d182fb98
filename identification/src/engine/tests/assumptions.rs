//! Assumptions about the command are selected by the likelihood ratio.

use super::*;
use crate::experiment::Assumptions;
use crate::recording::Hold;

const USUAL: Assumptions = Assumptions {
    is_held: false,
    begins_at_rest: false,
};
const HELD: Assumptions = Assumptions {
    is_held: true,
    ..USUAL
};
const AT_REST: Assumptions = Assumptions {
    begins_at_rest: true,
    ..USUAL
};

/// The output of black box 1 under these assumptions about its command, as an encoder measures it.
fn answered(
    command: impl Fn(f64) -> f64,
    rate_hz: f64,
    assumptions: Assumptions,
    seed: u64,
) -> Recording {
    let count = (6.0 * rate_hz) as u32;
    let time_s: Vec<f64> = (0..count).map(|i| f64::from(i) / rate_hz).collect();
    let recording = Recording {
        name: "run".into(),
        command_deg: time_s.iter().map(|t| command(*t)).collect(),
        angle_deg: vec![0.0; time_s.len()],
        time_s,
        ..Default::default()
    };
    // The check requires an angle that varies.
    let mut ready = recording.clone();
    ready.angle_deg[1] = 1.0;
    let run = Experiment::try_new(ready)
        .expect("a recording")
        .under(assumptions);
    let model = models::named("black-box-1").expect("a model");
    let truth = |p: &crate::ModelParameter| {
        let known = BLACK_BOX_1.iter().find(|(name, _)| *name == p.name);
        known.map_or(p.default, |(_, value)| *value)
    };
    let values: Vec<f64> = model.parameters().iter().map(truth).collect();
    let mut angle_deg = vec![0.0; run.len()];
    let output = &mut |i: usize, sample: crate::Sample| angle_deg[i] = sample.angle_deg;
    model.simulate(&run, &values, output);
    noisy(
        Recording {
            angle_deg,
            hold: Hold::Auto,
            ..recording
        },
        seed,
    )
}

fn assert_found(recording: Recording, assumptions: Assumptions) {
    let fit = fitted(&problem("black-box-1", vec![recording]));
    assert_eq!(fit.assumptions, assumptions);
    for (name, truth) in BLACK_BOX_1 {
        let e = fit.estimate(name).expect("an estimate");
        let is_within = !e.identifiable || (e.value - truth).abs() < 3.0 * e.standard_error;
        assert!(is_within, "{e:?}");
    }
}

/// From 0.2 to 2.2 Hz.
fn chirp(t: f64) -> f64 {
    let phase = std::f64::consts::TAU * (0.2 * t + t * t / 6.0);
    15.0 * phase.sin()
}

/// From 0.2 to 9.2 Hz.
fn quick_chirp(t: f64) -> f64 {
    let phase = std::f64::consts::TAU * (0.2 * t + 0.75 * t * t);
    10.0 * phase.sin()
}

#[test]
fn a_chirp_with_a_zero_order_hold_is_distinguished_from_a_smooth_one() {
    for assumptions in [USUAL, HELD] {
        assert_found(answered(quick_chirp, 50.0, assumptions, 1), assumptions);
    }
}

#[test]
fn a_chirp_with_an_undetermined_hold_is_assumed_smooth_with_a_warning() {
    let recording = answered(chirp, 250.0, HELD, 1);
    let delay = |hold: Hold| {
        let recording = Recording {
            hold,
            ..recording.clone()
        };
        let fit = fitted(&problem("black-box-1", vec![recording]));
        let delay = fit.estimate("delay_s").expect("an estimate").clone();
        (delay.value, delay.standard_error, fit.is_hold_undetermined)
    };
    let (smooth_s, error_s, is_open) = delay(Hold::Auto);
    assert!(is_open);
    let (held_s, _, is_still_open) = delay(Hold::Zero);
    assert!(!is_still_open);
    assert!(
        (held_s - 0.0175).abs() < 3.0 * error_s,
        "{held_s} {error_s}"
    );
    // Half a sample of 4 ms.
    assert!(
        (smooth_s - held_s - 0.002).abs() < error_s,
        "{smooth_s} {held_s}"
    );
}

/// Alternating steps.
fn steps(t: f64) -> f64 {
    if ((t / 0.7) as u32).is_multiple_of(2) {
        45.0
    } else {
        -20.0
    }
}

#[test]
fn a_command_that_arrives_at_the_first_sample_is_distinguished_from_an_earlier_one() {
    // Commands of 45 deg that step, to an actuator at 0 deg.
    for assumptions in [USUAL, AT_REST] {
        assert_found(answered(steps, 250.0, assumptions, 2), assumptions);
    }
}

#[test]
fn a_held_out_recording_is_predicted_from_its_own_initial_condition() {
    let fitted_to = noisy(simulated(ModelKind::BlackBox1, "pulse", 80, &[]), 1);
    let problem = problem("black-box-1", vec![fitted_to]);
    let fit = fitted(&problem);
    let left_out = Experiment::try_new(answered(steps, 250.0, AT_REST, 3)).expect("a recording");
    let prediction = predict(&problem, &fit, &left_out).expect("a prediction");
    // Noise of 0.05 deg and 12 bits of 0.088 deg: 0.056 deg, of which the mean magnitude is 0.8
    // times.
    assert!(prediction.mean_absolute_error_deg() < 0.05);
}
