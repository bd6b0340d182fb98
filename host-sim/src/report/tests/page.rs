//! The page as a whole.

use super::super::*;
use crate::plot::{Figure, Panel, Series};

fn page() -> Page {
    let figure = |title: &str| {
        let series = Series::new("angle", 1, &[0.0, 1.0], &[0.0, 1.0]);
        Figure::new(title, "time (s)").panel(Panel::new("angle (deg)").series(series))
    };
    let mut table = Table::new("Parameters", &[("name", ""), ("value", "")]);
    table.push(["pole".into(), Cell::Number(30.0, 1)]);
    Page::new("Models & <servos>")
        .introduction("First.\n\nSecond <b>.")
        .section(
            Section::new("Steps")
                .text("Text.")
                .figure(figure("Up"))
                .figure(figure("Down")),
        )
        .section(
            Section::new("Bode")
                .warning("contradiction")
                .figure(figure("Gain")),
        )
        .parameters(table)
}

#[test]
fn figures_are_numbered_through_and_the_contents_lead_to_the_sections() {
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
fn texts_are_escaped_and_parted_into_paragraphs() {
    let html = page().render();
    assert!(html.contains("<h1>Models &amp; &lt;servos&gt;</h1>"));
    assert!(html.contains("<p>First.</p>\n<p>Second &lt;b&gt;.</p>"));
    assert!(html.contains("<p class=\"warning\">contradiction</p>"));
}

#[test]
fn names_in_backticks_are_code_and_a_lone_backtick_is_itself() {
    let section = Section::new("").note("`a<b` and `c").remark("Why?", "`d`");
    let html = Page::new("").section(section).render();
    assert!(html.contains("<p class=\"note\"><code>a&lt;b</code> and `c</p>"));
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
fn the_footer_tells_version_and_parameters() {
    let html = page().render();
    let (_, footer) = html.split_once("<footer>").expect("a footer");
    assert!(footer.contains(env!("CARGO_PKG_VERSION")) && footer.contains("<td>pole</td>"));
}

#[test]
fn a_page_that_cannot_be_written_is_named() {
    let error = page()
        .write("/no such folder/report.html".as_ref())
        .expect_err("an error");
    assert!(
        error.to_string().contains("/no such folder/report.html"),
        "{error}"
    );
}
