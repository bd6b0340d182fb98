//! A figure as a self-contained HTML page, interactive with uPlot and without network access.
//!
//! The page contains the data for uPlot and the SVG, which is shown without scripts and in print
//! and can be saved. A content security policy forbids the page to load anything. The HTML is in
//! `templates/figure.html` and `templates/document.html`.

use askama::Template;
use serde::{Serialize, Serializer};

use super::figure::{Figure, Panel, Scale, Series, Style};
use super::palette::PALETTE;
use super::points::{Point, points, range};

/// uPlot, with its licence in `UPLOT_LICENSE`.
pub const UPLOT_JS: &str = include_str!("../../assets/uplot/uPlot.iife.min.js");
/// The licence of uPlot.
pub const UPLOT_LICENSE: &str = include_str!("../../assets/uplot/LICENSE");
/// The style of uPlot.
pub const UPLOT_CSS: &str = include_str!("../../assets/uplot/uPlot.min.css");
/// The script that draws a figure from [`json`].
pub const FIGURE_JS: &str = include_str!("../../assets/page/figure.js");
pub(crate) const PAGE_JS: &str = include_str!("../../assets/page/page.js");
pub(crate) const PAGE_CSS: &str = include_str!("../../assets/page/page.css");

/// Columns of samples that are distinguished: more than those of the SVG, so that zooming shows
/// more.
const COLUMNS: usize = 900;
/// Significant digits of the data: a millisecond in a day, and a thousandth of a degree in a turn.
const X_DIGITS: u8 = 8;
const Y_DIGITS: u8 = 6;

#[derive(Template)]
#[template(path = "figure_page.html")]
struct FigurePage<'a> {
    title: &'a str,
    figure: &'a Figure,
}

/// Renders a page that contains only this figure.
pub fn render(figure: &Figure) -> String {
    let page = FigurePage {
        title: &figure.title,
        figure,
    };
    // Writing to a string does not fail.
    page.render().unwrap_or_default()
}

/// Escapes text for the content and the attributes of HTML and XML.
pub(crate) fn escape(text: &str) -> String {
    let Ok(escaped) = askama::filters::escape(text, askama::filters::Html);
    escaped.to_string()
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

/// A number with a limited number of digits. NaN becomes `null`.
struct Number(f64);

impl Number {
    fn rounded(value: f64, digits: u8) -> Self {
        let text = format!("{value:.*e}", usize::from(digits) - 1);
        Self(text.parse().unwrap_or(f64::NAN))
    }
}

/// The ordinates. The number of decimals follows from the largest value, so that values that cannot
/// be distinguished from zero on the axis become zero.
fn ordinates(points: &[Point]) -> Vec<Number> {
    let y = points.iter().map(|p| p.1);
    let largest = range(y.clone().map(f64::abs)).map_or(0.0, |(_, largest)| largest);
    // The smallest normal number has 308 decimals.
    let decimals = (f64::from(Y_DIGITS) - 1.0 - largest.log10().floor()).clamp(0.0, 308.0) as usize;
    let rounded = |y| format!("{y:.decimals$}").parse().unwrap_or(f64::NAN);
    y.map(|y| Number(rounded(y))).collect()
}

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // Every integer below 2^53 is exact. Writing it as one saves the ".0".
        if self.0.fract() == 0.0 && self.0.abs() < 9_007_199_254_740_992.0 {
            serializer.serialize_i64(self.0 as i64)
        } else {
            serializer.serialize_f64(self.0)
        }
    }
}

/// The data for the script as JSON, in which no label can end the enclosing `<script>`.
pub fn json(figure: &Figure) -> String {
    let panel = |p| panel_data(p, figure.x_scale);
    let data = FigureData {
        x_label: &figure.x_label,
        x_log: figure.x_scale == Scale::Log,
        panels: figure.panels.iter().map(panel).collect(),
    };
    // Serialising strings and numbers does not fail.
    serde_json::to_string(&data)
        .unwrap_or_default()
        .replace('<', "\\u003c")
}

fn panel_data(panel: &Panel, x_scale: Scale) -> PanelData<'_> {
    let series = |s| series_data(s, x_scale);
    PanelData {
        y_label: &panel.y_label,
        y_step: panel.y_step,
        series: panel.series.iter().map(series).collect(),
    }
}

fn series_data(series: &Series, x_scale: Scale) -> SeriesData<'_> {
    let points = points(series, x_scale, COLUMNS);
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
        y: ordinates(&points),
    }
}
