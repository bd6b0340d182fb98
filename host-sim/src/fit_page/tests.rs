//! The content of the page.

use super::*;
use crate::settings::ModelKind;
use identification::{
    Experiment, Options, Recording,
    compare::{Candidate, Comparison},
    models::named,
    synthetic,
};

/// A run of black box 1, as a noisy encoder shows it at 250 Hz.
fn noisy(input: &str, seed: u64) -> Recording {
    let run = synthetic::simulated(ModelKind::BlackBox1, input, 80, &[]);
    synthetic::noisy(run.expect("a run"), seed)
}

fn page_of(comparison: &Comparison, nonparametric: &NonparametricAnalysis) -> Page {
    page(&Content {
        assessments: &comparison.assessments,
        ranking: Some(&comparison.ranking),
        nonparametric,
        notes: &[],
        origin: "Made today by: actuator identify.",
    })
}

#[test]
fn the_page_shows_every_recording_residual_and_parameter_and_is_self_contained() {
    let experiment = |input, seed| {
        let recording = noisy(input, seed);
        Experiment::try_new(recording).expect("a recording")
    };
    let (fitted, held_out) = ([experiment("pulse", 1)], [experiment("3-2-1-1", 2)]);
    let candidates = Candidate::forms(&named("black-box-1").expect("a model"));
    let options = Options {
        starts: 2,
        ..Options::default()
    };
    let comparison = Comparison::of(&candidates, &fitted, &held_out, &options, &|_| {});
    let comparison = comparison.expect("they fit");
    let nonparametric = NonparametricAnalysis::of(&fitted);
    let page = page_of(&comparison, &nonparametric);
    let titles: Vec<&str> = page.figures().map(|f| f.title.as_str()).collect();
    assert_eq!(titles[..2], ["pulse", "3-2-1-1"]);
    let residuals = titles.iter().filter(|t| t.starts_with("Residuals of"));
    assert_eq!(residuals.count(), 4);
    assert!(titles.contains(&"Bode plot of the recordings"));
    let html = page.render();
    // The warnings of the chosen model are expanded, those of the others are collapsed.
    let folds = html.matches("<summary>black-box-1 ").count();
    assert_eq!(folds, 3, "{html}");
    for text in [
        "pole_rad_s",
        "black-box-1 is enough",
        "is rate limited for",
        "Theil",
        "AIC",
    ] {
        assert!(html.contains(text), "{text}");
    }
    assert!(html.contains("default-src 'none'") && !html.contains("src="));
    let document = identification::document::document(&comparison.assessments, &nonparametric, &[]);
    let pole = &document["models"][0]["parameters"][0];
    assert_eq!(pole["name"], "pole_rad_s");
    assert!((pole["estimate"].as_f64().expect("a number") - 30.0).abs() < 0.5);
    assert_eq!(pole["identifiable"], true);
}

#[test]
fn the_curves_of_the_best_complete_models_are_drawn() {
    let recording = noisy("pulse", 1);
    let fitted = [Experiment::try_new(recording).expect("a recording")];
    let models = ["black-box-2", "black-box-1"].map(|name| named(name).expect("a model"));
    let candidates: Vec<_> = models.iter().flat_map(Candidate::forms).collect();
    let options = Options {
        starts: 2,
        ..Options::default()
    };
    let comparison = Comparison::of(&candidates, &fitted, &[], &options, &|_| {});
    let comparison = comparison.expect("they fit");
    let page = page_of(&comparison, &NonparametricAnalysis::of(&fitted));
    let figure = page.figures().next().expect("a figure");
    // By the BIC the simpler one is better.
    let caption = &figure.caption;
    let places = ["black-box-1: fit", "black-box-2: fit", "without"].map(|text| caption.find(text));
    assert!(places[0] < places[1] && places[1].is_some(), "{caption}");
    assert_eq!(places[2], None, "{caption}");
    assert!(
        page.render()
            .contains("The curves are those of the best 2 complete models of 8")
    );
}
