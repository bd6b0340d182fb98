//! The assessment of fits with known parameters.

use super::*;
use model_core::actuator::ModelKind;

use crate::{
    Options, Quiet, engine,
    models::named,
    testing::{noisy, simulated},
};

fn assessed(model: &str, kind: ModelKind, input: &str, held_out: &str) -> Assessment {
    let experiment = |input: &str, seed| {
        Experiment::try_new(noisy(simulated(kind, input, 80, &[]), seed)).expect("a recording")
    };
    let model = named(model).expect("a model");
    let problem = Problem::try_new(model, vec![experiment(input, 1)]).expect("a problem");
    let fit = engine::fit(&problem, &Options::default(), &Quiet).expect("a fit");
    let held_out = [experiment(held_out, 2)];
    Assessment::of("it", &problem, fit, &held_out).expect("a prediction")
}

#[test]
fn a_true_model_has_white_residuals_and_reports_the_time_at_the_rate_limit() {
    let found = assessed(
        "black-box-1",
        ModelKind::BlackBox1,
        "pulse",
        "variable-step",
    );
    let [experiment] = found.experiments.as_slice() else {
        panic!("one")
    };
    let correlations = experiment.correlations.as_ref().expect("noise");
    assert!(
        correlations.whiteness.is_white(),
        "{:?}",
        correlations.whiteness
    );
    assert!(!correlations.is_correlated_with_input());
    // 90 deg at 240 and at 350 deg/s, but for the last 240/30 and 350/30 deg.
    let expected_s = (90.0 - 8.0) / 240.0 + (90.0 - 350.0 / 30.0) / 350.0;
    // A sample's half at each of the four ends.
    assert!((experiment.limited.rate_limited_s() - expected_s).abs() < 0.008);
    let warned = found
        .warnings
        .iter()
        .any(|w| w.contains("pulse is rate limited for 0.5"));
    assert!(warned, "{:?}", found.warnings);
    let validation = overall(&found.validation).expect("it was predicted");
    assert!(validation.fit_percent > 99.0, "{validation:?}");
    assert!(validation.theil.inequality < 0.01);
}

#[test]
fn the_residual_of_a_model_of_too_low_order_is_reported_as_correlated_with_the_command() {
    let found = assessed("black-box-1", ModelKind::BlackBox2, "3-2-1-1", "pulse");
    let warned = |what: &str| found.warnings.iter().any(|w| w.contains(what));
    assert!(warned("not white"), "{:?}", found.warnings);
    assert!(
        warned("correlated with the command"),
        "{:?}",
        found.warnings
    );
    let criteria = &found.criteria;
    assert!(found.effective_samples < found.fit.samples as f64 / 2.0);
    assert!(criteria.bic > criteria.aic);
}
