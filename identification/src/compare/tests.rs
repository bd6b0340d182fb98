//! The comparison selects the model that generated the data, or reports that it cannot.

use super::*;
use model_core::actuator::ModelKind;

use crate::{
    models::named,
    testing::{noisy, simulated},
};

fn experiment(kind: ModelKind, input: &str, set: &[(&str, f64)], seed: u64) -> Experiment {
    let recording = noisy(simulated(kind, input, 80, set), seed);
    Experiment::try_new(recording).expect("a recording")
}

fn candidates(models: &[&str]) -> Vec<Candidate> {
    let models = models.iter().map(|name| named(name).expect("a model"));
    models.flat_map(|m| Candidate::forms(&m)).collect()
}

fn options() -> Options {
    Options {
        starts: 4,
        ..Options::default()
    }
}

fn compared(models: &[&str], fitted: &[Experiment], held_out: &[Experiment]) -> Comparison {
    let candidates = candidates(models);
    Comparison::of(&candidates, fitted, held_out, &options(), &|_| {}).expect("they fit")
}

#[test]
fn a_model_has_a_variant_for_each_effect_that_can_be_left_out() {
    let names = |model| {
        let forms = Candidate::forms(&named(model).expect("a model"));
        forms.into_iter().map(|form| form.name).collect::<Vec<_>>()
    };
    assert_eq!(
        names("black-box-1"),
        [
            "black-box-1",
            "black-box-1 without delay",
            "black-box-1 without rate limits",
            "black-box-1 without delay and rate limits",
        ]
    );
    // Its rate limits are fixed at infinity by default.
    assert_eq!(names("grey-box"), ["grey-box", "grey-box without delay"]);
}

#[test]
fn rate_limited_first_order_data_are_distinguished_from_all_other_models() {
    let fitted = [experiment(ModelKind::BlackBox1, "pulse", &[], 1)];
    let comparison = compared(&["black-box-1", "black-box-2"], &fitted, &[]);
    let best = &comparison.assessments[comparison.ranking.ranks[0].index];
    assert_eq!(
        comparison.assessments[comparison.ranking.enough].name,
        "black-box-1"
    );
    assert!(best.fit.fit_percent > 99.0);
    let unlimited = comparison
        .ranking
        .ranks
        .iter()
        .find(|r| {
            comparison.assessments[r.index]
                .name
                .ends_with("without rate limits")
        })
        .expect("it was compared");
    assert!(unlimited.is_distinguishable, "{}", unlimited.reason);
}

#[test]
fn models_are_compared_by_the_independent_samples_of_the_one_that_fits_best() {
    let fitted = [experiment(ModelKind::BlackBox2, "variable-step", &[], 1)];
    let comparison = compared(&["black-box-1", "black-box-2", "grey-box"], &fitted, &[]);
    let (ranks, all) = (&comparison.ranking.ranks, &comparison.assessments);
    let best = &all[ranks[0].index];
    assert_eq!(best.name, "black-box-2");
    let n = best.effective_samples;
    for rank in ranks {
        let this = &all[rank.index];
        // The residuals of the others are coloured by the dynamics that they lack.
        let has_fewer = this.effective_samples < 0.5 * n;
        assert!(has_fewer || this.name == best.name, "{}", this.name);
        let beyond = this.unknowns() as f64 - best.unknowns() as f64;
        let expected = n * (this.fit.cost / best.fit.cost).ln() + beyond * n.ln();
        let found = rank.score - ranks[0].score;
        assert!(
            (found - expected).abs() < 1e-9 * n,
            "{}: {found} {expected}",
            this.name
        );
    }
}

#[test]
fn limits_that_are_never_reached_do_not_justify_their_parameters() {
    // 1 deg at 30 rad/s needs at most 60 deg/s.
    let set = [("delay_s", 0.0175)];
    let scale = |mut e: crate::Recording| {
        e.command_deg.iter_mut().for_each(|c| *c *= 0.05);
        e.angle_deg.iter_mut().for_each(|a| *a *= 0.05);
        e
    };
    let unlimited = [
        ("rate_limit_up_deg_s", 1e5),
        ("rate_limit_down_deg_s", 1e5),
        set[0],
    ];
    let run = |input, seed| {
        let recording = scale(simulated(ModelKind::BlackBox1, input, 80, &unlimited));
        Experiment::try_new(noisy(recording, seed)).expect("a recording")
    };
    let comparison = compared(
        &["black-box-1"],
        &[run("3-2-1-1", 1)],
        &[run("variable-step", 2)],
    );
    let enough = &comparison.assessments[comparison.ranking.enough];
    assert_eq!(enough.name, "black-box-1 without rate limits");
    assert!(
        comparison.ranking.verdict.contains("do not distinguish"),
        "{}",
        comparison.ranking.verdict
    );
}

#[test]
fn no_variant_that_leaves_more_out_fits_better() {
    let fitted = [experiment(ModelKind::GreyBox, "variable-step", &[], 1)];
    let comparison = compared(&["black-box-1", "black-box-2"], &fitted, &[]);
    let cost = |name: &str| {
        let mut assessments = comparison.assessments.iter();
        assessments.find(|a| a.name == name).expect("it").fit.cost
    };
    for model in ["black-box-1", "black-box-2"] {
        for less in [
            "without delay",
            "without rate limits",
            "without delay and rate limits",
        ] {
            // Removing an insignificant limit may increase the cost within the threshold.
            assert!(
                cost(model) <= cost(&format!("{model} {less}")) * 1.01,
                "{model} {less}"
            );
        }
    }
    for form in ["", " without delay", " without delay and rate limits"] {
        let [one, two] = [1, 2].map(|order| cost(&format!("black-box-{order}{form}")));
        assert!(two <= one * (1.0 + 1e-3), "{form}: {two} {one}");
    }
}

#[test]
fn each_recording_is_predicted_by_the_fit_to_the_others() {
    let inputs = [("pulse", 1), ("3-2-1-1", 2), ("variable-step", 3)];
    let runs = inputs.map(|(input, seed)| experiment(ModelKind::BlackBox1, input, &[], seed));
    let candidates = candidates(&["black-box-1"]);
    let reported = std::cell::Cell::new(0);
    let progress = |done| {
        assert_eq!(done, reported.get() + 1);
        reported.set(done);
    };
    let crossed = Comparison::leave_one_out(&candidates, &runs, &options(), &progress);
    let crossed = crossed.expect("they fit");
    let fits = Comparison::leave_one_out_fits(candidates.len(), runs.len());
    assert_eq!(reported.get(), fits);
    assert_eq!(crossed.ranking.criterion, LEFT_OUT);
    let whole = compared(&["black-box-1"], &runs, &[]);
    for index in 0..runs.len() {
        let mut others = runs.to_vec();
        let left_out = [others.remove(index)];
        let fold = compared(&["black-box-1"], &others, &left_out);
        let assessments = crossed.assessments.iter().zip(&fold.assessments);
        for (crossed, fold) in assessments {
            assert_eq!(crossed.validation.len(), runs.len());
            assert_eq!(crossed.validation[index].fit, fold.validation[0].fit);
        }
    }
    for (crossed, whole) in crossed.assessments.iter().zip(&whole.assessments) {
        assert_eq!(crossed.fit.estimates.len(), whole.fit.estimates.len());
        assert_eq!(crossed.fit.cost, whole.fit.cost);
    }
    let enough = &crossed.assessments[crossed.ranking.enough];
    assert_eq!(enough.name, "black-box-1");
}

#[test]
fn a_candidate_that_cannot_be_fitted_without_one_recording_is_refused_with_its_name() {
    // Alone, the short one has too few samples for all parameters.
    let mut short = noisy(simulated(ModelKind::BlackBox1, "pulse", 80, &[]), 2);
    for column in [
        &mut short.time_s,
        &mut short.command_deg,
        &mut short.angle_deg,
    ] {
        column.drain(..240);
        column.truncate(20);
    }
    short.name = "short".into();
    let runs = [
        experiment(ModelKind::BlackBox1, "pulse", &[], 1),
        Experiment::try_new(short).expect("a recording"),
    ];
    let candidates = candidates(&["black-box-1"]);
    let crossed = Comparison::leave_one_out(&candidates, &runs, &options(), &|_| {});
    let crossed = crossed.expect("the variants with few parameters are fitted");
    let (name, error) = &crossed.refused[0];
    assert_eq!(name, "black-box-1 (fitted without pulse)");
    let is_expected = matches!(error, IdentifyError::TooFewSamples { .. });
    assert!(is_expected, "{error}");
    let all = crossed.assessments.len() + crossed.refused.len();
    assert_eq!(all, candidates.len());
    let alone = Comparison::leave_one_out(&candidates, &runs[..1], &options(), &|_| {});
    let error = alone.map(|_| ()).expect_err("no other recording");
    assert_eq!(error, IdentifyError::NoRecording);
}
