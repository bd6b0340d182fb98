//! Tests of the drift of a clock that noise does not hide.

use super::*;

/// The drift that is reported of a noiseless recording whose angle has this one.
fn reported(share: f64) -> Option<f64> {
    let run = simulated(ModelKind::BlackBox1, "pulse", 80, &[]);
    let experiment = Experiment::try_new(run.clone()).expect("a recording");
    let model = models::named("black-box-1").expect("a model");
    let truth = |p: &crate::ModelParameter| {
        let known = BLACK_BOX_1.iter().find(|(name, _)| *name == p.name);
        known.map_or(p.default, |(_, value)| *value)
    };
    let values: Vec<f64> = model.parameters().iter().map(truth).collect();
    let mut drifting = run;
    model.simulate(&experiment.on_clock(share), &values, &mut |i, sample| {
        drifting.angle_deg[i] = sample.angle_deg;
    });
    let fit = fitted(&problem("black-box-1", vec![drifting]));
    fit.consistency.drift.map(|drift| drift.share)
}

#[test]
fn a_drift_is_reported_of_a_noiseless_recording_and_none_of_a_steady_clock() {
    assert_eq!(reported(0.0), None);
    for share in [0.002, -0.007, 0.012] {
        let reported = reported(share).expect("a drift");
        // It is determined to a few digits, with the sign of the angle's instants.
        assert!(
            (reported.abs() / share.abs() - 1.0).abs() < 0.01,
            "{share}: {reported}"
        );
        assert_eq!(reported > 0.0, share > 0.0);
    }
}
