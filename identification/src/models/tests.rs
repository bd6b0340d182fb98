//! The exact solutions against the tick-by-tick models of the simulator, and sensitivities against
//! central differences.

use super::*;
use crate::testing::simulated;
use model_core::actuator::{ModelKind, PlantKind, Settings};

/// The parameters of the simulator by the names of a model; the initial state is zero.
fn truth(model: &dyn Model, kind: ModelKind, set: &[(&str, f64)]) -> Vec<f64> {
    let settings = Settings::new(kind, PlantKind::FirstOrder);
    let value = |p: &crate::ModelParameter| {
        let set = set.iter().find(|(name, _)| p.name == *name);
        let known = settings.values().find(|v| v.parameter.name == p.name);
        set.map(|s| s.1).or(known.map(|v| v.value)).unwrap_or(0.0)
    };
    model.parameters().iter().map(value).collect()
}

fn worst(model: &dyn Model, kind: ModelKind, input: &str, every: u64, set: &[(&str, f64)]) -> f64 {
    let recording = simulated(kind, input, every, set);
    let run = Experiment::try_new(recording).expect("a recording");
    let mut worst = 0.0_f64;
    let mut count = 0;
    model.simulate(&run, &truth(model, kind, set), &mut |i, sample| {
        worst = worst.max((sample.angle_deg - run.recording.angle_deg[i]).abs());
        count += 1;
    });
    assert_eq!(count, run.len());
    worst
}

#[test]
fn the_exact_solution_agrees_with_the_simulator() {
    let cases: [(&dyn Model, ModelKind, f64); 3] = [
        // The simulator switches modes at its next tick: 50 us times at most 50 us p 350 deg/s.
        (&BlackBox1, ModelKind::BlackBox1, 2e-5),
        (&BlackBox2, ModelKind::BlackBox2, 2e-3),
        (&GreyBox, ModelKind::GreyBox, 2e-3),
    ];
    for (model, kind, tolerance) in cases {
        for input in ["pulse", "variable-step", "3-2-1-1"] {
            for every in [80, 400, 77] {
                let error = worst(model, kind, input, every, &[]);
                // Where no sample is at a step, the step is known only to a sample.
                if every != 77 {
                    assert!(error < tolerance, "{kind} {input} {every}: {error}");
                }
            }
        }
    }
}

#[test]
fn a_smooth_command_is_interpolated_between_its_samples() {
    let cases: [(&dyn Model, ModelKind); 3] = [
        (&BlackBox1, ModelKind::BlackBox1),
        (&BlackBox2, ModelKind::BlackBox2),
        (&GreyBox, ModelKind::GreyBox),
    ];
    for (model, kind) in cases {
        for (input, every, tolerance) in [
            // The simulator holds its command for a tick: half a tick at 310 deg/s is 8e-3 deg.
            ("chirp", 80, 1e-2),
            // Five samples per period at the end, and an unknown instant at which the chirp stops
            // after its last sample.
            ("chirp", 400, 0.1),
            ("ramp", 80, 4e-3),
            ("sine", 400, 4e-3),
        ] {
            let error = worst(model, kind, input, every, &[]);
            assert!(error < tolerance, "{kind} {input} {every}: {error}");
        }
    }
}

#[test]
fn every_limit_acts_as_in_the_simulator() {
    let stop = ("position_limit_deg", 60.0);
    assert!(worst(&BlackBox1, ModelKind::BlackBox1, "pulse", 80, &[stop]) < 2e-5);
    let two = BlackBox2;
    // The simulator reaches its stops and limits at ticks: 50 us at 350 deg/s.
    assert!(worst(&two, ModelKind::BlackBox2, "variable-step", 80, &[stop]) < 1.75e-2);
    let limits = [
        ("rate_limit_up_deg_s", 100.0),
        ("rate_limit_down_deg_s", 150.0),
        ("rate_anti_windup_gain", 2.0),
        ("motor_gain_up", 2.4),
        ("motor_gain_down", 3.5),
        ("delay_s", 0.0123),
        stop,
    ];
    let grey = GreyBox;
    let error = worst(&grey, ModelKind::GreyBox, "variable-step", 80, &limits);
    assert!(error < 2e-2, "{error}");
}

/// Asserts that the sensitivities agree with central differences.
fn assert_derivatives(model: &dyn Model, run: &Experiment, values: &[f64], free: &[usize]) {
    let mut slopes = vec![Vec::new(); run.len()];
    model.sensitivity(run, values, free, &mut |i, _, slope| {
        slopes[i] = slope.to_vec()
    });
    for (column, &parameter) in free.iter().enumerate() {
        let step = 1e-6 * values[parameter].abs().max(1e-3);
        let angles = |sign: f64| {
            let mut shifted = values.to_vec();
            shifted[parameter] += sign * step;
            let mut angles = vec![0.0; run.len()];
            model.simulate(run, &shifted, &mut |i, s| angles[i] = s.angle_deg);
            angles
        };
        let (above, below) = (angles(1.0), angles(-1.0));
        let scale = slopes.iter().fold(0.0_f64, |m, s| m.max(s[column].abs()));
        let mut misses = 0;
        for i in 0..run.len() {
            let difference = (above[i] - below[i]) / (2.0 * step);
            misses += usize::from((slopes[i][column] - difference).abs() > 1e-4 * scale + 1e-6);
        }
        let name = model.parameters()[parameter].name;
        // A sample at a corner has a different derivative on each side.
        assert!(
            misses <= run.len() / 200,
            "{name}: {misses} of {}",
            run.len()
        );
    }
}

#[test]
fn derivatives_are_those_of_the_exact_solution() {
    for input in ["pulse", "variable-step", "chirp"] {
        let one = BlackBox1;
        let run = Experiment::try_new(simulated(ModelKind::BlackBox1, input, 80, &[])).unwrap();
        let values = [25.0, 0.0191, 200.0, 300.0, 0.97, 0.4, 75.0, 0.5];
        assert_derivatives(&one, &run, &values, &[0, 1, 2, 3, 4, 5, 6, 7]);
        let forms: [(&dyn Model, [f64; 2]); 2] = [
            (&BlackBox2, [700.0, 40.0]),
            (&BlackBox2Oscillator, [26.0, 0.7]),
        ];
        for (two, [a, b]) in forms {
            let values = [a, b, 0.0191, 200.0, 300.0, 0.97, 0.4, 75.0, 0.5, 3.0];
            assert_derivatives(two, &run, &values, &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
        }
        let grey = GreyBox;
        let values = [
            2.4, 3.5, 0.12, 0.0191, 1.2, 9.0, 7.0, 6.0, 1.0, 90.0, 180.0, 250.0, 75.0, 0.5, 2.0,
        ];
        let all: Vec<usize> = (0..values.len()).collect();
        assert_derivatives(&grey, &run, &values, &all);
    }
}

/// Parameters that are set to other values.
type Set = &'static [(&'static str, f64)];

#[test]
fn derivatives_by_the_command_are_those_of_the_exact_solution() {
    let servo = named("servo-m1").expect("a model");
    let cases: [(&dyn Model, ModelKind); 4] = [
        (&BlackBox1, ModelKind::BlackBox1),
        (&BlackBox2, ModelKind::BlackBox2),
        (&GreyBox, ModelKind::GreyBox),
        (servo.as_ref(), ModelKind::GreyBox),
    ];
    // A level that remains and a delay that is no multiple of a sample.
    let levels = [20.0, 25.0, 25.0, -30.0, 5.0];
    let starts: Vec<usize> = (0..levels.len()).map(|k| 25 * k).collect();
    let recording = |levels: &[f64]| crate::Recording {
        time_s: (0..125).map(|i| f64::from(i) * 4e-3).collect(),
        command_deg: (0..125).map(|i| levels[i / 25]).collect(),
        angle_deg: (0..125).map(f64::from).collect(),
        hold: crate::Hold::Zero,
        ..Default::default()
    };
    for (model, kind) in cases {
        let values = truth(model, kind, &[]);
        let run = |levels: &[f64]| {
            let run = Experiment::try_new(recording(levels)).expect("a recording");
            run.with_segments_at(&starts)
        };
        let angles = |levels: &[f64]| {
            let mut angles = Vec::new();
            model.simulate(&run(levels), &values, &mut |_, s| angles.push(s.angle_deg));
            angles
        };
        let mut slopes = Vec::new();
        model.command_sensitivity(&run(&levels), &values, 0..5, &mut |_, _, slope| {
            slopes.push(slope.to_vec());
        });
        let step = 1e-5;
        for k in 0..levels.len() {
            let moved = |by: f64| {
                let mut levels = levels;
                levels[k] += by;
                angles(&levels)
            };
            let ends = moved(step).into_iter().zip(moved(-step));
            for (i, (high, low)) in ends.enumerate() {
                let difference = (high - low) / (2.0 * step);
                // Rounding of angles of 30 deg over 2e-5 deg.
                let error = (slopes[i][k] - difference).abs();
                assert!(error < 1e-6, "{} {k} {i}: {error}", model.name());
            }
        }
    }
}

#[test]
fn a_model_that_is_fast_against_its_samples_gives_the_same_result_as_with_close_samples() {
    let cases: [(&dyn Model, ModelKind, Set); 3] = [
        (&BlackBox1, ModelKind::BlackBox1, &[("pole_rad_s", 900.0)]),
        (
            &BlackBox2,
            ModelKind::BlackBox2,
            &[
                ("position_gain_per_s2", 2e5),
                ("rate_gain_per_s", 1500.0),
                ("rate_limit_up_deg_s", 3000.0),
            ],
        ),
        (
            &GreyBox,
            ModelKind::GreyBox,
            &[("motor_time_constant_s", 0.002)],
        ),
    ];
    for (model, kind, set) in cases {
        for input in ["pulse", "chirp"] {
            let close = Experiment::try_new(simulated(kind, input, 4, set)).expect("a recording");
            let far = close.with_samples(|i| i.is_multiple_of(100));
            let answers = |run: &Experiment| {
                let mut angles = vec![0.0; run.len()];
                let values = truth(model, kind, set);
                model.simulate(run, &values, &mut |i, s| angles[i] = s.angle_deg);
                angles
            };
            let (close, far) = (answers(&close), answers(&far));
            let pairs = close.iter().step_by(100).zip(&far);
            let worst = pairs.fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
            // The only difference is a limit that is reached and left again within a fraction of a
            // step.
            assert!(worst < 1e-4, "{kind} {input}: {worst}");
        }
    }
}
