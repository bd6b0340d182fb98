//! A figure as a self-contained HTML page, interactive with uPlot and without any network.
//!
//! Beside the data for uPlot stands the SVG: it is what is seen without scripts and in print, and
//! what the page offers to save. A content security policy forbids the page to load anything.

use std::fmt::Write as _;

use serde::{Serialize, Serializer};

use super::figure::{Figure, Panel, Scale, Series, Style};
use super::palette::{PALETTE, PALETTE_DARK};
use super::points::{Point, points, range};
use super::svg;

const UPLOT_JS: &str = include_str!("../../assets/uplot/uPlot.iife.min.js");
const UPLOT_LICENSE: &str = include_str!("../../assets/uplot/LICENSE");
const UPLOT_CSS: &str = include_str!("../../assets/uplot/uPlot.min.css");
const PAGE_JS: &str = include_str!("../../assets/page/page.js");
const PAGE_CSS: &str = include_str!("../../assets/page/page.css");

/// Twice the columns of the SVG, for those who zoom in.
const COLUMNS: usize = 1200;
/// Significant digits of the data: a ms in a day, and a thousandth of a degree in a turn.
const X_DIGITS: u8 = 8;
const Y_DIGITS: u8 = 6;

/// How the plots are handled, as a paragraph; it is seen only where they are.
pub(crate) const HINT: &str = "<p class=\"hint\">Drag across a plot to zoom, double-click to \
    return. Click a name in a legend to hide its curve.</p>\n";

/// A page with this figure alone.
pub fn render(figure: &Figure) -> String {
    document(&figure.title, &(fragment(figure, 1) + HINT))
}

/// A complete HTML document around `body`, which may hold any number of [`fragment`]s.
pub fn document(title: &str, body: &str) -> String {
    let title = escape(title);
    let light = variables(&PALETTE);
    let dark = variables(&PALETTE_DARK);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
         style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>{UPLOT_CSS}\n:root{{{light}}}\n\
         @media (prefers-color-scheme: dark){{:root{{{dark}}}}}\n{PAGE_CSS}</style>\n</head>\n\
         <body>\n{body}<script>/* {UPLOT_LICENSE}*/\n{UPLOT_JS}\n{PAGE_JS}</script>\n\
         </body>\n</html>\n"
    )
}

/// The colours of a palette as the CSS variables `--c0`, `--c1` ...
fn variables(palette: &[&str]) -> String {
    let variable = |(i, colour)| format!("--c{i}:{colour};");
    palette.iter().enumerate().map(variable).collect()
}

/// The `<figure>` of a page. `number` is that of the figure in its page.
///
/// What is of class `twice` stands in the SVG too and gives way to it.
pub fn fragment(figure: &Figure, number: usize) -> String {
    let mut html = format!(
        "<figure id=\"figure-{number}\">\n<div class=\"head\"><h3>Figure {number}. \
         <span class=\"twice\">{}</span></h3>\
         <span class=\"tools\"><button aria-pressed=\"false\">Show SVG</button>\
         <button>Save SVG</button></span></div>\n<div class=\"plots\"></div>\n\
         <div class=\"static\">{}</div>\n<script type=\"application/json\">{}</script>\n",
        escape(&figure.title),
        svg::render(figure),
        json(figure),
    );
    if !figure.caption.is_empty() {
        let _ = writeln!(html, "<figcaption>{}</figcaption>", escape(&figure.caption));
    }
    for warning in &figure.warnings {
        let _ = writeln!(html, "<p class=\"warning twice\">{}</p>", escape(warning));
    }
    html + "</figure>\n"
}

/// Text that means itself in the content and in the attributes of HTML.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            _ => escaped.push(c),
        }
    }
    escaped
}

#[derive(Serialize)]
struct FigureData<'a> {
    x_label: &'a str,
    x_log: bool,
    panels: Vec<PanelData<'a>>,
}

#[derive(Serialize)]
struct PanelData<'a> {
    y_label: &'a str,
    y_log: bool,
    y_step: Option<f64>,
    series: Vec<SeriesData<'a>>,
}

#[derive(Serialize)]
struct SeriesData<'a> {
    label: &'a str,
    colour: usize,
    style: &'static str,
    x: Vec<Number>,
    y: Vec<Number>,
}

/// A number without needless digits; NaN is `null`.
struct Number(f64);

impl Number {
    fn rounded(value: f64, digits: u8) -> Self {
        let text = format!("{value:.*e}", usize::from(digits) - 1);
        Self(text.parse().unwrap_or(f64::NAN))
    }
}

/// The ordinates. On a linear axis the digits are counted from those of the largest value: what
/// cannot be told from zero there is zero.
fn ordinates(points: &[Point], scale: Scale) -> Vec<Number> {
    let y = points.iter().map(|p| p.1);
    if scale == Scale::Log {
        return y.map(|y| Number::rounded(y, Y_DIGITS)).collect();
    }
    let largest = range(y.clone().map(f64::abs)).map_or(0.0, |(_, largest)| largest);
    // 308: the smallest normal number has as many decimals. Without NaN: the limits are constant.
    let decimals = (f64::from(Y_DIGITS) - 1.0 - largest.log10().floor()).clamp(0.0, 308.0) as usize;
    let rounded = |y| format!("{y:.decimals$}").parse().unwrap_or(f64::NAN);
    y.map(|y| Number(rounded(y))).collect()
}

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // 2^53: up to there every whole number is exact. It saves the ".0".
        if self.0.fract() == 0.0 && self.0.abs() < 9_007_199_254_740_992.0 {
            serializer.serialize_i64(self.0 as i64)
        } else {
            serializer.serialize_f64(self.0)
        }
    }
}

/// The data for the script, in such a form that no label can end the `<script>` around it.
fn json(figure: &Figure) -> String {
    let panel = |p| panel_data(p, figure.x_scale);
    let data = FigureData {
        x_label: &figure.x_label,
        x_log: figure.x_scale == Scale::Log,
        panels: figure.panels.iter().map(panel).collect(),
    };
    // Strings and numbers always serialise.
    serde_json::to_string(&data)
        .unwrap_or_default()
        .replace('<', "\\u003c")
}

fn panel_data(panel: &Panel, x_scale: Scale) -> PanelData<'_> {
    let series = |s| series_data(s, x_scale, panel.y_scale);
    PanelData {
        y_label: &panel.y_label,
        y_log: panel.y_scale == Scale::Log,
        y_step: panel.y_step,
        series: panel.series.iter().map(series).collect(),
    }
}

fn series_data(series: &Series, x_scale: Scale, y_scale: Scale) -> SeriesData<'_> {
    let points = points(series, x_scale, y_scale, COLUMNS);
    SeriesData {
        label: &series.label,
        colour: series.colour % PALETTE.len(),
        style: match series.style {
            Style::Line => "line",
            Style::Dashed => "dashed",
            Style::Step => "step",
            Style::Points => "points",
        },
        x: points
            .iter()
            .map(|p| Number::rounded(p.0, X_DIGITS))
            .collect(),
        y: ordinates(&points, y_scale),
    }
}
