//! Tests of the search, on recordings with known parameters.

mod assumptions;
mod drift;
mod edge_cases;
mod many;
mod motors;
mod nested;
mod outliers;
mod scouts;

use super::*;
use crate::models;
use crate::recording::Recording;
use crate::testing::{noisy, simulated};
use model_core::actuator::ModelKind;
use model_core::sensors::noise::Noise;

/// The defaults of the simulator's models.
const BLACK_BOX_1: [(&str, f64); 6] = [
    ("pole_rad_s", 30.0),
    ("delay_s", 0.0175),
    ("rate_limit_up_deg_s", 240.0),
    ("rate_limit_down_deg_s", 350.0),
    ("gain", 1.0),
    ("offset_deg", 0.0),
];
const BLACK_BOX_2: [(&str, f64); 7] = [
    ("position_gain_per_s2", 900.0),
    ("rate_gain_per_s", 54.0),
    ("delay_s", 0.0175),
    ("rate_limit_up_deg_s", 240.0),
    ("rate_limit_down_deg_s", 350.0),
    ("gain", 1.0),
    ("offset_deg", 0.0),
];
const GREY_BOX: [(&str, f64); 4] = [
    ("motor_gain_up", 2.836),
    ("motor_gain_down", 2.836),
    ("motor_time_constant_s", 1.0 / 7.586),
    ("delay_s", 0.0175),
];

/// Parameters by name.
type Truth = &'static [(&'static str, f64)];

/// A model with the simulator's model and its parameters.
fn truths() -> [(&'static str, ModelKind, Truth); 3] {
    [
        ("black-box-1", ModelKind::BlackBox1, &BLACK_BOX_1),
        ("black-box-2", ModelKind::BlackBox2, &BLACK_BOX_2),
        ("grey-box", ModelKind::GreyBox, &GREY_BOX),
    ]
}

fn problem(model: &str, runs: Vec<Recording>) -> Problem {
    let model = models::named(model).expect("a model");
    let runs = runs
        .into_iter()
        .map(|r| Experiment::try_new(r).expect("a recording"));
    Problem::try_new(model, runs.collect()).expect("a problem")
}

fn fitted(problem: &Problem) -> Fit {
    fit(problem, &Options::default(), &Quiet).expect("a fit")
}

#[test]
fn at_250_hz_every_parameter_is_within_three_standard_errors() {
    for (model, kind, truth) in truths() {
        for input in ["pulse", "variable-step", "3-2-1-1", "prbs"] {
            let run = noisy(simulated(kind, input, 80, &[]), 3);
            let fit = fitted(&problem(model, vec![run]));
            for (name, truth) in truth {
                let e = fit.estimate(name).expect("an estimate");
                let error = (e.value - truth).abs();
                let is_within = !e.identifiable || error < 3.0 * e.standard_error;
                assert!(is_within, "{model} {input} {e:?}");
            }
        }
    }
}

#[test]
fn at_50_hz_every_parameter_is_within_one_percent() {
    for (model, kind, truth) in truths() {
        for input in ["pulse", "variable-step"] {
            let mut run = simulated(kind, input, 400, &[]);
            // With noise, a pulse of 250 samples determines the gains of black box 2 only to 3 %:
            // for that model only the sampling is tested.
            if kind == ModelKind::BlackBox1 {
                run = noisy(run, 1);
            }
            let fit = fitted(&problem(model, vec![run]));
            for (name, truth) in truth.iter().filter(|(_, truth)| *truth != 0.0) {
                let value = fit.value(name).expect("an estimate");
                assert!(
                    (value / truth - 1.0).abs() < 0.01,
                    "{model} {input} {name} {value}"
                );
            }
        }
    }
}

#[test]
fn at_50_hz_with_noise_every_parameter_of_each_model_is_within_one_percent() {
    for (model, kind, truth) in truths() {
        let inputs = ["pulse", "variable-step", "3-2-1-1", "prbs"].into_iter();
        // As many runs as determine each parameter to 0.3 %.
        let runs = (0..3).flat_map(|seed| inputs.clone().map(move |input| (input, seed)));
        let runs = runs.map(|(input, seed)| noisy(simulated(kind, input, 400, &[]), seed));
        let fit = fitted(&problem(model, runs.collect()));
        for (name, truth) in truth.iter().filter(|(_, truth)| *truth != 0.0) {
            let e = fit.estimate(name).expect("an estimate");
            assert!((e.value / truth - 1.0).abs() < 0.01, "{model} {e:?}");
        }
    }
}

#[test]
fn the_pole_is_estimated_from_a_pulse_that_is_mostly_rate_limited() {
    let run = noisy(simulated(ModelKind::BlackBox1, "pulse", 80, &[]), 1);
    let fit = fitted(&problem("black-box-1", vec![run]));
    assert!((fit.value("pole_rad_s").expect("a pole") / 30.0 - 1.0).abs() < 0.01);
    // From 0 to the last 8 deg at 240 deg/s, and back to the last 11.7 deg at 350 deg/s.
    let limited_s = 82.0 / 240.0 + 78.333 / 350.0;
    let found_s = fit.experiments[0].rate_limited_s;
    assert!((found_s - limited_s).abs() < 0.01, "{found_s}");
}

#[test]
fn a_slow_sine_does_not_identify_the_rate_limits() {
    let mut run = simulated(ModelKind::BlackBox1, "sine", 80, &[("delay_s", 0.05)]);
    // A quarter of a hertz.
    run.time_s.iter_mut().for_each(|t| *t *= 4.0);
    let fit = fitted(&problem("black-box-1", vec![noisy(run, 2)]));
    for name in ["rate_limit_up_deg_s", "rate_limit_down_deg_s"] {
        assert!(
            !fit.estimate(name).expect("an estimate").identifiable,
            "{name}"
        );
    }
    assert!(fit.estimate("gain").expect("a gain").identifiable);
}

#[test]
fn recordings_share_parameters_and_have_their_own() {
    let run = |offset, seed| {
        let set = [("offset_deg", offset)];
        noisy(
            simulated(ModelKind::BlackBox1, "variable-step", 80, &set),
            seed,
        )
    };
    let mut problem = problem("black-box-1", vec![run(2.0, 1), run(-3.0, 2)]);
    problem
        .scope("offset_deg", Scope::Own)
        .expect("a parameter");
    problem.fix("gain", 1.0).expect("a parameter");
    let fit = fitted(&problem);
    let offsets = fit.estimates.iter().filter(|e| e.name == "offset_deg");
    let offsets: Vec<_> = offsets.map(|e| (e.experiment, e.value)).collect();
    assert_eq!(offsets.len(), 2);
    for ((experiment, value), (index, truth)) in offsets.iter().zip([(0, 2.0), (1, -3.0)]) {
        assert_eq!(*experiment, Some(index));
        assert!((value - truth).abs() < 0.01, "{value}");
    }
    let poles = fit.estimates.iter().filter(|e| e.name == "pole_rad_s");
    assert_eq!(poles.count(), 1);
    assert!(fit.estimate("gain").expect("a gain").fixed);
}

#[test]
fn a_stop_is_estimated_without_a_starting_value() {
    for stop_deg in [20.0, 60.0] {
        let set = [("position_limit_deg", stop_deg)];
        let run = noisy(simulated(ModelKind::BlackBox1, "pulse", 80, &set), 1);
        let mut problem = problem("black-box-1", vec![run]);
        problem.free("position_limit_deg").expect("a parameter");
        let fit = fitted(&problem);
        let stop = fit.estimate("position_limit_deg").expect("an estimate");
        assert!(stop.identifiable, "{stop:?}");
        let error = (stop.value - stop_deg).abs();
        assert!(error < 3.0 * stop.standard_error, "{stop:?}");
    }
}

#[test]
fn a_bound_holds_and_is_reported() {
    let run = noisy(simulated(ModelKind::BlackBox1, "pulse", 80, &[]), 1);
    let mut problem = problem("black-box-1", vec![run]);
    problem.bound("pole_rad_s", 5.0, 20.0).expect("a bound");
    let fit = fitted(&problem);
    let pole = fit.estimate("pole_rad_s").expect("a pole");
    assert_eq!(pole.value, 20.0);
    assert_eq!(pole.at_bound, Some(crate::Bound::High));
    assert!(pole.standard_error.is_nan());
    assert!(problem.bound("pole_rad_s", 30.0, 20.0).is_err());
    assert!(problem.fix("no_such", 1.0).is_err());
}

#[test]
fn a_fitted_model_predicts_a_held_out_recording() {
    let run = |input, seed| noisy(simulated(ModelKind::BlackBox2, input, 80, &[]), seed);
    let problem = problem("black-box-2", vec![run("variable-step", 1)]);
    let fit = fitted(&problem);
    let left_out = Experiment::try_new(run("pulse", 2)).expect("a recording");
    let prediction = predict(&problem, &fit, &left_out).expect("a prediction");
    assert!(prediction.fit_percent > 99.8, "{}", prediction.fit_percent);
    // Noise of 0.05 deg has a mean magnitude of 0.04 deg, with 12 bits 0.045.
    assert!(prediction.mean_absolute_error_deg() < 0.05);
}
