//! The rendered page.

use super::*;
use crate::{
    plot::{Figure, Panel, Series},
    table::Cell,
};

fn page() -> Page {
    let figure = |title: &str| {
        let series = Series::new("angle", 1, &[0.0, 1.0], &[0.0, 1.0]);
        Figure::new(title, "time (s)").panel(Panel::new("angle (deg)").series(series))
    };
    let mut table = Table::new("Parameters", &[("name", ""), ("value", "")]);
    table.push(["pole".into(), Cell::Number(30.0, 1)]);
    let contradiction = Block::Warning(String::new(), "contradiction".into());
    Page {
        title: "Models & <servos>",
        introduction: "First.\n\nSecond <b>.",
        sections: vec![
            Section::new(
                "Steps",
                ["Text.".into(), figure("Up").into(), figure("Down").into()],
            ),
            Section::new("Bode", [contradiction, figure("Gain").into()]),
        ],
        parameters: vec![table],
    }
}

/// A page with this block only.
fn page_of(block: Block) -> Page {
    Page {
        title: "",
        introduction: "",
        sections: vec![Section::new("", [block])],
        parameters: Vec::new(),
    }
}

#[test]
fn figures_are_numbered_across_sections_and_the_contents_link_to_the_sections() {
    let html = page().render();
    for (number, title) in [(1, "Up"), (2, "Down"), (3, "Gain")] {
        assert!(html.contains(&format!(
            "<h3>Figure {number}. <span class=\"twice\">{title}</span></h3>"
        )));
    }
    for number in [1, 2] {
        assert!(html.contains(&format!("href=\"#section-{number}\"")));
        assert!(html.contains(&format!("<section id=\"section-{number}\">")));
    }
}

#[test]
fn text_is_escaped_and_split_into_paragraphs() {
    let html = page().render();
    assert!(html.contains("<h1>Models &#38; &#60;servos&#62;</h1>"));
    assert!(html.contains("<p>First.</p>\n<p>Second &#60;b&#62;.</p>"));
    assert!(html.contains("<p class=\"warning\">contradiction</p>"));
}

#[test]
fn names_in_backticks_are_code_and_an_unpaired_backtick_is_literal() {
    let html = page_of(Block::Note("`a<b` and `c".into())).render();
    assert!(html.contains("<p class=\"note\"><code>a&#60;b</code> and `c</p>"));
    let html = page_of(Block::Warning("Why?".into(), "`d`".into())).render();
    assert!(html.contains("<p class=\"warning\"><strong>Why?</strong> <code>d</code></p>"));
}

#[test]
fn all_links_stay_on_the_page() {
    let html = page().render();
    assert!(!html.contains("src=") && !html.contains("url("));
    assert_eq!(
        html.matches("href=").count(),
        html.matches("href=\"#").count()
    );
}

#[test]
fn the_footer_contains_the_version_and_the_parameters() {
    let html = page().render();
    let (_, footer) = html.split_once("<footer>").expect("a footer");
    assert!(footer.contains(env!("CARGO_PKG_VERSION")) && footer.contains("<td>pole</td>"));
}

#[test]
fn an_error_of_writing_names_the_file() {
    let error = page()
        .write("/no such folder/report.html".as_ref())
        .expect_err("an error");
    assert!(
        error.to_string().contains("/no such folder/report.html"),
        "{error}"
    );
}

#[test]
fn a_table_is_escaped_and_its_numbers_are_aligned_right() {
    let mut table = Table::new("Steps & <ramps>", &[("model", ""), ("t90", "ms")]);
    table.push(["a<b".into(), Cell::Number(76.753, 1)]);
    table.push(["none".into(), Cell::Number(f64::NAN, 1)]);
    table.push(["short row".into()]);
    let html = page_of(table.into()).render();
    assert!(html.contains("<td>a&#60;b</td><td class=\"number\">76.8</td>"));
    assert!(html.contains("Steps &#38; &#60;ramps&#62;"));
    assert!(html.contains("<td class=\"number\">–</td>"));
    let (_, rest) = html.split_once("<div class=\"table\">").expect("a table");
    let (table, _) = rest.split_once("</div>").expect("its end");
    roxmltree::Document::parse(table).expect("the table is well-formed");
}
