//! Unusual recordings: a result or an error with the reason.

use super::*;
use crate::RecordingError;

#[test]
fn a_recording_without_information_is_refused_with_the_reason() {
    let refused = |recording: Recording| Experiment::try_new(recording).expect_err("no experiment");
    assert!(matches!(
        refused(Recording::default()),
        RecordingError::Short { found: 0, .. }
    ));
    let full = simulated(ModelKind::BlackBox1, "pulse", 80, &[]);
    let short = Recording {
        time_s: vec![0.0, 0.1, 0.2],
        command_deg: vec![0.0, 1.0, 1.0],
        angle_deg: vec![0.0, 0.5, 0.9],
        ..Default::default()
    };
    assert!(matches!(
        refused(short),
        RecordingError::Short { found: 3, .. }
    ));
    let mut still = full.clone();
    still.angle_deg.fill(1.0);
    assert!(matches!(
        refused(still),
        RecordingError::Constant("angle_deg")
    ));
    let mut nothing = full.clone();
    nothing.angle_deg.fill(f64::NAN);
    assert!(matches!(refused(nothing), RecordingError::Short { .. }));
    let mut infinite = full.clone();
    infinite.angle_deg[5] = f64::INFINITY;
    assert!(matches!(
        refused(infinite),
        RecordingError::Value { index: 6, .. }
    ));
    let mut backward = full;
    backward.time_s[9] = 0.0;
    assert!(matches!(
        refused(backward),
        RecordingError::Time { index: 10, .. }
    ));
}

#[test]
fn gaps_and_missing_samples_change_the_estimates_by_less_than_their_standard_errors() {
    let full = noisy(simulated(ModelKind::BlackBox1, "variable-step", 80, &[]), 1);
    let whole = fitted(&problem("black-box-1", vec![full.clone()]));
    let mut holes = full.clone();
    for i in (0..holes.len()).filter(|i| i % 7 == 3) {
        holes.angle_deg[i] = f64::NAN;
    }
    // A gap within which the command is constant.
    let keep = |i: &usize| !(640..720).contains(i);
    let selected: Vec<usize> = (0..holes.len()).filter(keep).collect();
    let take = |column: &[f64]| selected.iter().map(|i| column[*i]).collect();
    let gapped = Recording {
        time_s: take(&holes.time_s),
        command_deg: take(&holes.command_deg),
        angle_deg: take(&holes.angle_deg),
        ..holes.clone()
    };
    let fit = fitted(&problem("black-box-1", vec![gapped]));
    for (name, _) in BLACK_BOX_1 {
        let (a, b) = (fit.estimate(name).unwrap(), whole.estimate(name).unwrap());
        assert!((a.value - b.value).abs() < 2.0 * b.standard_error, "{name}");
    }
}

/// A pulse with the motor off until 0.5 s and from 1.5 s to 2.5 s, where it is turned by hand.
fn switched(seed: u64) -> Recording {
    let mut run = noisy(simulated(ModelKind::BlackBox1, "pulse", 80, &[]), seed);
    let is_on = |t: &f64| f64::from(u8::from(*t >= 0.5 && !(1.5..2.5).contains(t)));
    let motor_on: Vec<f64> = run.time_s.iter().map(is_on).collect();
    for (i, t) in run.time_s.iter().enumerate() {
        if (1.5..2.49).contains(t) {
            run.angle_deg[i] += 40.0 * (9.0 * t).sin();
        }
    }
    run.motor_on = Some(motor_on);
    run
}

#[test]
fn motion_while_the_motor_is_off_is_not_compared() {
    for model in ["black-box-1", "grey-box"] {
        let run = switched(4);
        let fit = fitted(&problem(model, vec![run.clone()]));
        let compared = &fit.experiments[0].residual_deg;
        let on = run.motor_on.expect("a column");
        let is_right = on
            .iter()
            .zip(compared)
            .all(|(on, r)| r.is_nan() == (*on == 0.0));
        assert!(is_right, "{model}");
        // 125 of 1250 samples before, 250 within.
        assert_eq!(fit.samples, 875, "{model}");
    }
    let fit = fitted(&problem("black-box-1", vec![switched(4)]));
    for (name, truth) in BLACK_BOX_1 {
        let e = fit.estimate(name).expect("an estimate");
        assert!((e.value - truth).abs() < 4.0 * e.standard_error, "{e:?}");
    }
    let mut never = switched(4);
    never.motor_on = Some(vec![0.0; never.len()]);
    assert_eq!(Experiment::try_new(never).err(), Some(RecordingError::Off));
}

#[test]
fn uneven_samples_are_compared_at_their_instants() {
    let mut run = simulated(ModelKind::BlackBox2, "pulse", 2, &[]);
    // Random samples about 4 ms apart, of samples every 0.1 ms.
    let mut noise = Noise::new(1, 1);
    let mut selected = vec![0];
    while let Some(next) = selected
        .last()
        .map(|l: &usize| l + 40 + noise.gaussian(10.0) as usize)
    {
        if next >= run.len() {
            break;
        }
        selected.push(next);
    }
    // The steps of the command are samples as well: otherwise their instants would be unknown.
    selected.extend([10_000, 30_000]);
    selected.sort_unstable();
    selected.dedup();
    for column in [&mut run.time_s, &mut run.command_deg, &mut run.angle_deg] {
        *column = selected.iter().map(|i| column[*i]).collect();
    }
    let fit = fitted(&problem("black-box-2", vec![noisy(run, 2)]));
    for (name, truth) in BLACK_BOX_2 {
        let e = fit.estimate(name).expect("an estimate");
        assert!((e.value - truth).abs() < 3.0 * e.standard_error, "{e:?}");
    }
}

#[test]
fn a_long_recording_is_thinned_for_the_starts_and_fitted_completely() {
    let pulse = noisy(simulated(ModelKind::BlackBox1, "pulse", 80, &[]), 1);
    let mut long = Recording::default();
    let length_s = 5.0;
    for repeat in 0..80 {
        let from = f64::from(repeat) * length_s;
        long.time_s.extend(pulse.time_s.iter().map(|t| t + from));
        long.command_deg.extend(&pulse.command_deg);
        long.angle_deg.extend(&pulse.angle_deg);
    }
    assert!(long.len() > 2 * preview::MANY_SAMPLES);
    let fit = fitted(&problem("black-box-1", vec![long]));
    assert_eq!(fit.samples, 100_000);
    assert!((fit.value("pole_rad_s").expect("a pole") / 30.0 - 1.0).abs() < 0.01);
}

#[test]
fn a_stopped_search_returns_the_best_result_so_far() {
    struct Stop;
    impl Progress for Stop {
        fn is_stopped(&self) -> bool {
            true
        }
    }
    let run = noisy(simulated(ModelKind::BlackBox1, "pulse", 80, &[]), 1);
    let fit = fit(
        &problem("black-box-1", vec![run]),
        &Options::default(),
        &Stop,
    )
    .expect("a fit");
    assert_eq!(fit.termination, crate::Termination::Interrupted);
    assert_eq!(fit.iterations, 0);
}
