//! A figure as SVG, drawn with the crate `kuva`.
//!
//! The title, the warnings and the legend are above the panels, so that they do not cover curves.

use std::sync::Arc;

use kuva::backend::svg::SvgBackend;
use kuva::plot::scatter::ScatterPlot;
use kuva::plot::{LinePlot, LineStyle};
use kuva::render::layout::{Layout, TickFormat};
use kuva::render::plots::Plot;
use kuva::render::render::{Primitive, Scene, render_multiple};
use kuva::render::theme::Theme;

use self::heading::{header, legend, plain, printable, text};
use super::axis;
use super::figure::{Figure, Panel, Scale, Series, Style};
use super::html::escape;
use super::palette::colour;
use super::points::{Point, held, points, range, straightened};

mod compact;
mod heading;

/// Lengths of a drawing, px at 96 dpi. Its text has the same size in all of them.
struct Size {
    width: f64,
    one_panel: f64,
    several_panels: f64,
    /// Size of the title.
    title: u32,
}

/// 190 mm wide: a page without its margins.
const PAGE: Size = Size {
    width: 720.0,
    one_panel: 320.0,
    several_panels: 190.0,
    title: 15,
};
/// 93 mm wide: one of two columns of a printed page, at which size it is read.
const COLUMN: Size = Size {
    width: 352.0,
    one_panel: 120.0,
    several_panels: 80.0,
    title: 13,
};
/// Space for the labels of the y axes, equal in all panels so that the panels are aligned.
const LEFT: f64 = 78.0;
const RIGHT: f64 = 22.0;
/// Space for the tick labels and the label of the x axis, below the last panel.
const BOTTOM: f64 = 43.0;
/// Space between two panels. The topmost tick label extends into half of it.
const GAP: f64 = 14.0;
const LINE_WIDTH: f64 = 1.6;
const DASHES: &str = "7 4";
/// Columns of samples that are distinguished: about one per pixel of the axis.
const COLUMNS: usize = 600;
const TEXT_SIZE: u32 = 12;
/// Greatest distance of a line from its samples, pixels.
const FINEST: f64 = 0.1;
/// Mean width of a letter in units of the text size, in the widest of the fonts.
const LETTER: f64 = 0.6;

/// Renders a figure as SVG: an XML document without the prologue, which can be embedded in HTML.
pub fn render(figure: &Figure) -> String {
    sized(figure, &PAGE)
}

/// As [`render`], 93 mm wide: the size of a column of a printed page.
pub fn render_column(figure: &Figure) -> String {
    sized(figure, &COLUMN)
}

fn sized(figure: &Figure, size: &Size) -> String {
    let mut scene = Scene::new(size.width, 0.0);
    scene.font_family = Some("DejaVu Sans, Verdana, Liberation Sans, Arial, sans-serif".into());
    scene.text_color = Some("#222222".into());
    let mut y = header(&mut scene, figure, size);
    y = legend(&mut scene, figure, size, y);
    y = panels(&mut scene, figure, size, y);
    scene.height = y;
    let svg = compact::compact(&SvgBackend::new().render_scene(&scene));
    // With a view box the drawing scales to its container.
    let name = escape(&printable(&figure.title));
    let root = format!(
        r#"<svg viewBox="0 0 {} {y}" role="img" aria-label="{name}" "#,
        size.width
    );
    svg.replacen("<svg ", &root, 1)
}

/// Draws the panels from top to bottom and returns the y below them.
fn panels(scene: &mut Scene, figure: &Figure, size: &Size, top: f64) -> f64 {
    let curves: Vec<Vec<Vec<Point>>> = figure
        .panels
        .iter()
        .map(|p| {
            let of = |s| points(s, figure.x_scale, COLUMNS);
            p.series.iter().map(of).collect()
        })
        .collect();
    let all_x = curves.iter().flatten().flatten().map(|p| p.0);
    let x_ends = axis::ends(range(all_x), figure.x_scale, 0.0);
    let mut y = top;
    for (i, (panel, curves)) in figure.panels.iter().zip(&curves).enumerate() {
        let last = i + 1 == figure.panels.len();
        let plot_height = if figure.panels.len() == 1 {
            size.one_panel
        } else {
            size.several_panels
        };
        let height = plot_height + GAP / 2.0 + if last { BOTTOM } else { GAP / 2.0 };
        let y_data = range(curves.iter().flatten().map(|p| p.1));
        let layout = layout((figure, panel), size, x_ends, y_data, last).with_height(height);
        let tolerance = y_data.map_or(0.0, |(low, high)| FINEST * (high - low) / plot_height);
        let straight = |style, run: &[Point]| match style {
            Style::Step => held(run),
            _ => straightened(run, figure.x_scale, tolerance),
        };
        let drawing = render_multiple(plots(panel, curves, straight), layout);
        scene.add(Primitive::GroupStart {
            transform: Some(format!("translate(0,{y})")),
            title: None,
            extra_attrs: None,
        });
        // The axes enclose all data. Clipping would need ids, which are shared by all figures of a
        // page.
        let clip = |e: &Primitive| matches!(e, Primitive::ClipStart { .. } | Primitive::ClipEnd);
        let drawn = drawing.elements.into_iter().filter(|e| !clip(e));
        drawn.for_each(|e| scene.add(e));
        if y_data.is_none() {
            text(scene, (LEFT + 12.0, GAP / 2.0 + 22.0), "no data", TEXT_SIZE);
        }
        scene.add(Primitive::GroupEnd);
        y += height;
    }
    y
}

/// The axes of a panel. Only the last panel has labels on the shared x axis.
fn layout(
    (figure, panel): (&Figure, &Panel),
    size: &Size,
    x: (f64, f64),
    y_data: Option<(f64, f64)>,
    last: bool,
) -> Layout {
    let stepped = panel
        .y_step
        .zip(y_data)
        .and_then(|(step, data)| axis::by_steps(data, step));
    let y = stepped.unwrap_or_else(|| axis::ends(y_data, Scale::Linear, 0.05));
    let mut layout = styled(size, x, y)
        .with_y_label(plain(&panel.y_label))
        .with_force_margins_y(GAP / 2.0, if last { BOTTOM } else { GAP / 2.0 });
    if figure.x_scale == Scale::Log {
        let ticks = TickFormat::Custom(Arc::new(log_tick));
        layout = layout.with_log_x().with_x_tick_format(ticks);
    }
    layout.y_tick_step = stepped.and(panel.y_step);
    layout.suppress_x_ticks = !last;
    layout.show_legend = false;
    if last {
        layout.with_x_label(plain(&figure.x_label))
    } else {
        layout
    }
}

/// Axes with exactly these limits, in the common style of all panels.
fn styled(size: &Size, x: (f64, f64), y: (f64, f64)) -> Layout {
    let theme = Theme {
        grid_color: "#e4e4e4".into(),
        ..Theme::light()
    };
    Layout::new(x, y)
        .with_x_axis_min(x.0)
        .with_x_axis_max(x.1)
        .with_y_axis_min(y.0)
        .with_y_axis_max(y.1)
        .with_width(size.width)
        .with_force_margins(LEFT, RIGHT)
        .with_y_label_wrap(
            (size.several_panels / (f64::from(TEXT_SIZE) * LETTER)).max(16.0) as usize,
        )
        .with_box_axes()
        .with_theme(theme)
        .with_label_size(TEXT_SIZE)
        .with_tick_size(TEXT_SIZE - 1)
        // As many ticks as the length of the axis allows.
        .with_ticks(0)
}

/// The label of a tick of a logarithmic axis: 0.1, 0.2, 0.5, 1 ... without rounding errors of the
/// powers of ten.
fn log_tick(value: f64) -> String {
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    if (1e-4..1e6).contains(&rounded) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

/// The curves of a panel: one line for each section without a gap, made `straight`, and a dot for a
/// single point.
fn plots(
    panel: &Panel,
    curves: &[Vec<Point>],
    straight: impl Fn(Style, &[Point]) -> Vec<Point>,
) -> Vec<Plot> {
    let mut plots = Vec::new();
    for (series, curve) in panel.series.iter().zip(curves) {
        let mut lone = Vec::new();
        for run in curve.split(|p| p.1.is_nan()) {
            if run.len() < 2 || series.style == Style::Points {
                lone.extend_from_slice(run);
            } else {
                plots.push(Plot::Line(line(series, straight(series.style, run))));
            }
        }
        let dots = ScatterPlot::new()
            .with_data(lone)
            .with_color(colour(series.colour))
            .with_size(2.4);
        plots.push(Plot::Scatter(dots));
    }
    plots
}

fn line(series: &Series, run: Vec<Point>) -> LinePlot {
    let line = LinePlot::new()
        .with_data(run)
        .with_color(colour(series.colour))
        .with_stroke_width(LINE_WIDTH);
    match series.style {
        Style::Step => line.with_step(),
        Style::Dashed => line.with_line_style(LineStyle::Custom(DASHES.into())),
        Style::Line | Style::Points => line,
    }
}
