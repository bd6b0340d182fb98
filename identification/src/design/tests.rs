//! Predicted standard errors against the scatter of fits.

use super::{inputs::*, *};
use crate::{Options, Quiet, engine, models::named, statistics::tests::white};

fn setup(duration_s: f64) -> ExperimentSetup {
    ExperimentSetup {
        resolution_deg: 0.0,
        duration_s,
        ..ExperimentSetup::new(named("black-box-1").expect("a model"))
    }
}

const LIMITS: Limits = Limits {
    bandwidth_hz: 4.775,
    most_deg: 60.0,
};

fn designed(setup: &ExperimentSetup, name: &str, is_beyond: bool) -> Designed {
    let designed = design(setup, name, &LIMITS, is_beyond).expect("an input");
    designed.expect("it can be made")
}

/// The scatter of each parameter over many fits to the same experiment with different noise, as a
/// share of the predicted standard error.
fn scatter(setup: &ExperimentSetup, design: &Designed, runs: u64) -> Vec<(&'static str, f64)> {
    let (experiment, _) = setup.simulated(&design.command_deg).expect("an experiment");
    let identified = design.prediction.parameters.iter();
    let identified = identified.filter_map(|p| Some((p.name, p.standard_error?)));
    let identified: Vec<(&str, f64)> = identified.collect();
    let mut found = vec![Vec::new(); identified.len()];
    for seed in 0..runs {
        let noise = white(experiment.len(), seed);
        let mut recording = (*experiment.recording).clone();
        for (angle, noise) in recording.angle_deg.iter_mut().zip(noise) {
            *angle += setup.noise_deg * noise;
            if setup.resolution_deg > 0.0 {
                *angle = (*angle / setup.resolution_deg).round() * setup.resolution_deg;
            }
        }
        let experiment = Experiment::try_new(recording).expect("a recording");
        let problem = Problem::try_new(setup.model.clone(), vec![experiment]).expect("a problem");
        let options = Options {
            starts: 1,
            ..Options::default()
        };
        let fit = engine::fit(&problem, &options, &Quiet).expect("a fit");
        for (values, (name, _)) in found.iter_mut().zip(&identified) {
            values.push(fit.value(name).expect("an estimate"));
        }
    }
    let ratio = |(values, (name, predicted)): (&Vec<f64>, &(&'static str, f64))| {
        let mean = values.iter().sum::<f64>() / runs as f64;
        let squares = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
        (*name, (squares / (runs - 1) as f64).sqrt() / predicted)
    };
    found.iter().zip(&identified).map(ratio).collect()
}

#[test]
fn the_predicted_errors_are_the_scatter_of_fits() {
    // Without and with the quantisation of the encoder, which counts as noise.
    for resolution_deg in [0.0, ENCODER_DEG] {
        let setup = ExperimentSetup {
            resolution_deg,
            ..setup(4.0)
        };
        let design = designed(&setup, "log-chirp", true);
        let ratios = scatter(&setup, &design, 60);
        assert_eq!(ratios.len(), 6, "{ratios:?}");
        for (name, ratio) in ratios {
            // The scatter of 60 runs is known to 9 %: three and a half times that, for the worst of
            // twelve.
            assert!((0.68..1.32).contains(&ratio), "{name}: {ratio}");
        }
    }
}

#[test]
fn amplitudes_are_the_largest_within_the_rate_limit() {
    let setup = setup(10.0);
    for name in ["log-chirp", "prbs", "3-2-1-1"] {
        let share = |design: &Designed, factor: f64| {
            let command: Vec<f64> = design.command_deg.iter().map(|c| c * factor).collect();
            setup.limited_share(&command).expect("a run")
        };
        let within = designed(&setup, name, false);
        assert_eq!(share(&within, 1.0), 0.0, "{name}");
        // The margin is a tenth: a fifth more exceeds the limit.
        assert!(share(&within, 1.2) > 0.0, "{name}");
        let beyond = designed(&setup, name, true);
        let is_strongest = beyond.amplitude_deg == LIMITS.most_deg;
        assert!(is_strongest || share(&beyond, 1.0) > 0.25, "{name}");
        assert!(is_strongest || share(&beyond, 0.98) <= 0.25, "{name}");
    }
}

#[test]
fn only_an_input_beyond_the_rate_limit_identifies_it() {
    let setup = setup(10.0);
    let within = designed(&setup, "log-chirp", false);
    let beyond = designed(&setup, "log-chirp", true);
    assert_eq!(within.prediction.limited.rate_limited_s(), 0.0);
    assert!(beyond.prediction.limited.rate_limited_s() > 1.0);
    assert!(beyond.amplitude_deg > within.amplitude_deg);
    let error = |design: &Designed, name: &str| {
        let found = design.prediction.parameters.iter().find(|p| p.name == name);
        found.expect("it is free").standard_error
    };
    assert_eq!(error(&within, "rate_limit_up_deg_s"), None);
    assert!(error(&beyond, "rate_limit_up_deg_s").is_some_and(|e| e < 5.0));
    assert!(error(&within, "pole_rad_s").is_some());
    assert_eq!(best(&[within, beyond]), Some(1));
}

#[test]
fn the_error_is_proportional_to_the_noise_and_to_the_inverse_root_of_the_duration() {
    let short = setup(10.0);
    let noisy = ExperimentSetup {
        noise_deg: 0.2,
        ..short.clone()
    };
    let command = designed(&short, "prbs", false).command_deg;
    let first = |setup: &ExperimentSetup, command: &[f64]| {
        let prediction = setup.predict(command).expect("a prediction");
        prediction.parameters[0].standard_error.expect("the pole")
    };
    let ratio = first(&noisy, &command) / first(&short, &command);
    assert!((ratio - 4.0).abs() < 1e-9, "{ratio}");
    let ratio = first(&short, &command.repeat(4)) / first(&short, &command);
    // Only the first repetition begins at rest.
    assert!((ratio - 0.5).abs() < 0.02, "{ratio}");
}

/// With the variances `A` and `F` of an estimate and of a value that are both free, and `C` of the
/// estimate where the value is exact, a value that is known with the variance `S` leaves
/// `C + (A - C) S/(F + S)`.
#[test]
fn a_held_value_with_an_error_adds_what_it_changes_in_the_estimates() {
    let both = setup(10.0);
    let command = designed(&both, "log-chirp", false).command_deg;
    let place = |name| both.model.parameter_index(name).expect("a parameter");
    let (pole, delay) = (place("pole_rad_s"), "delay_s");
    let variance = |setup: &ExperimentSetup, name: &str| {
        let prediction = setup.predict(&command).expect("a prediction");
        let found = prediction.parameters.iter().find(|p| p.name == name);
        let error = found.expect("it is free").standard_error;
        error.expect("it is identified").powi(2)
    };
    let held = |error: Option<f64>| {
        let mut setup = both.clone();
        setup.free[pole] = false;
        setup.held[pole] = error;
        variance(&setup, delay)
    };
    let (free, exact) = (variance(&both, delay), held(None));
    assert!(free > 1.1 * exact, "{free} {exact}");
    let of_pole = variance(&both, "pole_rad_s");
    for known in [0.1, 1.0, 10.0].map(|factor| factor * of_pole) {
        let expected = exact + (free - exact) * known / (of_pole + known);
        let found = held(Some(known.sqrt()));
        assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
    }
}

#[test]
fn every_input_of_the_catalogue_can_be_designed_or_is_refused_with_the_reason() {
    let setup = setup(10.0);
    for name in Input::NAMES {
        for is_beyond in [false, true] {
            let designed = design(&setup, name, &LIMITS, is_beyond).expect("an input");
            match designed {
                Ok(design) => assert!(design.amplitude_deg <= 60.0, "{name}"),
                Err(problem) => panic!("{name}: {problem}"),
            }
        }
    }
    assert!(design(&setup, "noise", &LIMITS, false).is_none());
}
