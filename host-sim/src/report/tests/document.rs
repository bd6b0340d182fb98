//! The page of the report.

use super::super::{contradictions, document, runs::INPUTS};
use super::*;
use crate::plot::{html::escape, svg};

fn html() -> String {
    document::page(comparison()).expect("a page").render()
}

#[test]
fn the_page_names_every_model_and_input_and_carries_the_warning() {
    let html = html();
    for name in MODELS.map(|model| model.name) {
        assert!(
            html.contains(&format!("<td>{}</td>", escape(name))),
            "{name}"
        );
    }
    for input in INPUTS {
        assert!(html.contains(input), "{input}");
    }
    assert!(html.contains("37.4 deg/s: contradicts the paper&#39;s own rate limits"));
}

#[test]
fn each_contradiction_appears_once() {
    let html = html();
    for contradiction in contradictions::ALL {
        let title = format!("<strong>{}</strong>", escape(contradiction.title));
        assert_eq!(html.matches(&title).count(), 1, "{title}");
    }
}

#[test]
fn the_page_is_complete_and_self_contained() {
    let html = html();
    let (_, content) = html.split_once("<body>").expect("a body");
    let (content, _) = content
        .rsplit_once("<script>")
        .expect("the script of the page");
    for unwanted in [
        "src=",
        "url(",
        "href=\"http",
        "NaN",
        // Marks of unfinished text, split so that a search for them does not find this test.
        concat!("TO", "DO"),
        concat!("FIX", "ME"),
        "{}",
        "``",
    ] {
        assert!(!content.contains(unwanted), "{unwanted}");
    }
    // The only addresses are the SVG namespace.
    let addresses = content.matches("http").count();
    assert_eq!(
        addresses,
        content.matches("http://www.w3.org/2000/svg").count()
    );
    assert!(html.len() < 5_000_000, "{} bytes", html.len());
}

#[test]
fn two_runs_give_the_same_bytes() {
    // One model in f64, one in fixed point, and the one with all sensors.
    let few = [MODELS[0], MODELS[7], MODELS[11]];
    let page = || {
        let comparison = Comparison::of(&few, &|| ()).expect("presets are valid");
        let page = document::page(&comparison).expect("a page").render();
        (page, comparison.to_json())
    };
    assert!(page() == page());
}

#[test]
fn titles_are_unique_because_they_become_file_names() {
    let page = document::page(comparison()).expect("a page");
    let mut titles: Vec<_> = page.figures().map(|figure| figure.title.clone()).collect();
    let count = titles.len();
    titles.sort_unstable();
    titles.dedup();
    assert_eq!(titles.len(), count);
}

#[test]
fn the_picture_in_the_readme_is_the_first_figure() {
    let page = document::page(comparison()).expect("a page");
    let first = page.figures().next().expect("a figure");
    // To update it: `actuator report --figures DIR`, then copy DIR/step-responses.svg.
    let picture = include_str!("../../../../docs/report-step.svg");
    assert!(
        picture == svg::render(first),
        "docs/report-step.svg is out of date"
    );
}

#[test]
fn each_run_is_reported_once() {
    let runs = std::sync::atomic::AtomicU64::new(0);
    let count = || {
        runs.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    };
    Comparison::of(&MODELS[..1], &count).expect("presets are valid");
    assert_eq!(runs.into_inner(), Comparison::steps(1));
}
