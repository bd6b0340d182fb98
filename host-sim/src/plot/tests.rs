//! Requirements on both renderers.

use proptest::prelude::*;
use roxmltree::Document;

use super::*;

/// A label with special characters of XML, HTML, scripts and the formulas of the SVG renderer.
const HOSTILE: &str = "a<b>&\"' </script><script>alert(1)</script> $x_1$ \u{0}";

fn hostile() -> Figure {
    Figure::new(HOSTILE, HOSTILE)
        .caption(HOSTILE)
        .warning(HOSTILE)
        .panel(Panel::new(HOSTILE).series(Series::new(HOSTILE, 1, &[0.0, 1.0], &[0.0, 1.0])))
}

/// The figure's data as the script of the page reads them.
fn embedded(html: &str) -> serde_json::Value {
    let (_, rest) = html
        .split_once("<script type=\"application/json\">")
        .expect("data");
    let (json, _) = rest.split_once("</script>").expect("the end of the data");
    serde_json::from_str(json).expect("JSON")
}

#[test]
fn special_characters_in_labels_are_escaped() {
    let html = html::render(&hostile());
    assert!(!html.contains("<script>alert"));
    assert_eq!(embedded(&html)["panels"][0]["series"][0]["label"], HOSTILE);

    let svg = svg::render(&hostile());
    let document = Document::parse(&svg).expect("well-formed");
    let seen: Vec<&str> = document.descendants().filter_map(|n| n.text()).collect();
    assert!(
        seen.iter()
            .any(|t| t.contains("</script><script>alert(1)</script> $x_1$")),
        "{seen:?}"
    );
}

#[test]
fn a_page_loads_no_resources() {
    let html = html::render(&hostile());
    for loading in [
        "src=",
        "href=",
        "url(",
        "@import",
        "import(",
        "fetch(",
        "XMLHttpRequest",
    ] {
        assert!(!html.contains(loading), "{loading}");
    }
    let addresses = html.matches("http://").count() + html.matches("https://").count();
    let namespaces = html.matches("xmlns=\"http://www.w3.org/2000/svg\"").count();
    let licence = html
        .matches("/*! https://github.com/leeoniya/uPlot")
        .count();
    assert_eq!(addresses, namespaces + licence);
    assert!(html.contains("default-src 'none'"));
}

#[test]
fn a_gap_is_null_in_html_and_splits_the_line_in_svg() {
    let series = Series::new(
        "",
        1,
        &[0.0, 1.0, 2.0, 3.0, 4.0],
        &[1.0, 2.0, f64::NAN, 2.0, 1.0],
    );
    let figure = Figure::new("", "").panel(Panel::new("").series(series));
    let data = embedded(&html::render(&figure));
    assert_eq!(
        data["panels"][0]["series"][0]["y"].to_string(),
        "[1,2,null,2,1]"
    );

    let svg = svg::render(&figure);
    assert!(!svg.contains("NaN"));
    let document = Document::parse(&svg).expect("well-formed");
    let lines = document
        .descendants()
        .filter(|n| n.has_tag_name(("http://www.w3.org/2000/svg", "path")));
    assert_eq!(lines.count(), 2);
}

#[test]
fn twenty_seconds_at_one_millisecond_stay_small() {
    let x: Vec<f64> = (0..=20_000).map(|i| f64::from(i) * 1e-3).collect();
    let y: Vec<f64> = x.iter().map(|t| 30.0 * (7.0 * t).sin()).collect();
    let figure = |x: &[f64], y: &[f64]| {
        Figure::new("", "").panel(Panel::new("").series(Series::new("", 1, x, y)))
    };
    let (full, empty) = (figure(&x, &y), figure(&[], &[]));
    let svg = svg::render(&full).len() - svg::render(&empty).len();
    assert!(svg < 60_000, "{svg}");
    let html = html::render(&full).len() - html::render(&empty).len();
    assert!(html - svg < 80_000, "{html}");
}

#[test]
fn figures_without_data_contain_a_note() {
    let nothing = Figure::new("", "");
    let empty = Figure::new("", "").log_x().panel(Panel::new("")).panel(
        Panel::new("")
            .series(Series::new("", 0, &[], &[]))
            .series(Series::new("", 9, &[0.0], &[])),
    );
    for figure in [nothing, empty] {
        let svg = svg::render(&figure);
        Document::parse(&svg).expect("well-formed");
        assert_eq!(svg.matches("no data").count(), figure.panels.len());
        html::render(&figure);
    }
}

#[test]
fn the_extension_selects_the_format_and_errors_name_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let figure = Figure::new("", "");
    save(&figure, &at("a.svg")).expect("an SVG");
    save(&figure, &at("a.html")).expect("a page");
    let read = |name| std::fs::read_to_string(at(name)).expect("the written file");
    assert!(read("a.svg").starts_with("<svg ") && read("a.html").starts_with("<!DOCTYPE html>"));
    for bad in ["a.png", "a", "missing/a.svg"] {
        let error = save(&figure, &at(bad)).expect_err(bad).to_string();
        assert!(error.contains(bad), "{error}");
    }
}

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<f64>(),
        -1e3..1e3,
        Just(0.0),
        Just(1e30),
        Just(-1e30),
        Just(1e-30)
    ]
}

fn any_series() -> impl Strategy<Value = Series> {
    let numbers = || prop::collection::vec(any_number(), 0..6);
    let style = prop::sample::select(vec![Style::Line, Style::Dashed, Style::Step, Style::Points]);
    (any::<String>(), any::<usize>(), numbers(), numbers(), style)
        .prop_map(|(label, colour, x, y, style)| Series::new(label, colour, &x, &y).style(style))
}

proptest! {
    #[test]
    fn the_svg_is_well_formed_for_any_numbers_and_labels(
        series in any_series(), other in any_series(), title in any::<String>(),
        log in any::<bool>(), step in any_number(),
    ) {
        let panel = Panel::new(title.clone()).y_step(step).series(series).series(other);
        let mut figure = Figure::new(title.clone(), title).panel(panel);
        if log { figure = figure.log_x(); }
        let svg = svg::render(&figure);
        prop_assert!(Document::parse(&svg).is_ok(), "{}", svg);
        prop_assert!(!svg.contains("NaN") && !svg.contains("inf"), "{}", svg);
        embedded(&html::render(&figure));
    }
}

#[test]
fn rendering_is_reproducible_and_uses_no_ids() {
    let svg = svg::render(&hostile());
    assert_eq!(svg, svg::render(&hostile()));
    assert!(!svg.contains(" id="));
}
