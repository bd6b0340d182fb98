use super::*;
use crate::testing::{noisy, simulated};
use model_core::actuator::ModelKind;

const INPUTS: [&str; 8] = [
    "pulse",
    "variable-step",
    "ramp",
    "chirp",
    "sine",
    "3-2-1-1",
    "prbs",
    "multisine",
];

fn run(input: &str) -> Recording {
    noisy(simulated(ModelKind::BlackBox1, input, 80, &[]), 1)
}

#[test]
fn no_recording_of_the_simulator_has_bad_samples_at_any_rate_with_or_without_noise() {
    let kinds = [
        ModelKind::BlackBox1,
        ModelKind::BlackBox2,
        ModelKind::GreyBox,
    ];
    for (kind, input) in kinds.into_iter().flat_map(|k| INPUTS.map(|i| (k, i))) {
        for every in [20, 80, 400, 2000] {
            for set in [&[][..], &[("pole_rad_s", 300.0)][..]] {
                if !set.is_empty() && kind != ModelKind::BlackBox1 {
                    continue;
                }
                let plain = simulated(kind, input, every, set);
                for recording in [noisy(plain.clone(), 3), plain] {
                    let found = bad_samples(&recording);
                    assert_eq!(found, [], "{kind} {input} every {every} {set:?}");
                }
            }
        }
    }
}

#[test]
fn isolated_readings_are_found_during_motion_and_at_rest() {
    for (input, place, off_deg) in [
        ("pulse", 340, 40.0),
        ("pulse", 900, -40.0),
        ("sine", 500, 25.0),
        ("prbs", 500, 60.0),
    ] {
        for length in 1..=3 {
            let mut recording = run(input);
            for angle in &mut recording.angle_deg[place..place + length] {
                *angle += off_deg;
            }
            let found: Vec<_> = bad_samples(&recording)
                .into_iter()
                .map(|b| (b.samples.start, b.samples.end))
                .collect();
            assert_eq!(found, [(place, place + length)], "{input}");
        }
    }
}

#[test]
fn one_percent_of_outliers_of_20_deg_is_found_except_for_the_small_ones() {
    let mut noise = model_core::sensors::noise::Noise::new(5, 0);
    let mut recording = run("pulse");
    let places: Vec<usize> = (0..12).map(|k| 40 + 97 * k).collect();
    let mut large = 0;
    for &place in &places {
        let off = noise.gaussian(20.0);
        recording.angle_deg[place] += off;
        large += usize::from(off.abs() > 5.0);
    }
    let found = bad_samples(&recording);
    assert!(
        found.len() >= large && found.len() <= places.len(),
        "{found:?}"
    );
    assert!(found.iter().all(|b| places.contains(&b.samples.start)));
}

#[test]
fn readings_that_freeze_while_the_shaft_moves_are_found() {
    // Not so long that the shaft has returned meanwhile.
    for (input, length) in [("pulse", 75), ("sine", 75), ("3-2-1-1", 40)] {
        let mut recording = run(input);
        let speed = |i: &usize| (recording.angle_deg[i + 5] - recording.angle_deg[*i]).abs();
        let fastest = (0..1000).max_by(|a, b| speed(a).total_cmp(&speed(b)));
        let from = fastest.expect("samples");
        let kept = recording.angle_deg[from];
        recording.angle_deg[from..from + length].fill(kept);
        let found = bad_samples(&recording);
        assert_eq!(found.len(), 1, "{input} {found:?}");
        assert!(matches!(found[0].fault, Fault::Frozen { .. }), "{input}");
        assert_eq!(found[0].samples, from + 1..from + length, "{input}");
    }
}

#[test]
fn the_response_after_a_gap_is_left_out_where_the_command_changed_in_it() {
    let cut = |from_s: f64, to_s: f64| {
        let recording = run("pulse");
        let keep = |i: &usize| !(from_s..to_s).contains(&recording.time_s[*i]);
        let places: Vec<usize> = (0..recording.len()).filter(keep).collect();
        let take = |column: &[f64]| places.iter().map(|&i| column[i]).collect::<Vec<f64>>();
        Recording {
            time_s: take(&recording.time_s),
            command_deg: take(&recording.command_deg),
            angle_deg: take(&recording.angle_deg),
            ..recording.clone()
        }
    };
    let recording = run("pulse");
    let step = recording.command_deg.windows(2).position(|w| w[0] != w[1]);
    let step_s = recording.time_s[step.expect("a step")];
    let found = bad_samples(&cut(step_s - 0.1, step_s + 0.25));
    assert_eq!(found.len(), 1);
    assert!(matches!(found[0].fault, Fault::AfterGap { gap_s } if (gap_s - 0.354).abs() < 5e-3));
    // Nothing is unknown where the command stays.
    assert_eq!(bad_samples(&cut(step_s - 0.4, step_s - 0.05)), []);
}
