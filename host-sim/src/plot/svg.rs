//! A figure as SVG, drawn with the crate `kuva`.
//!
//! The heading, the warnings and the legend stand above the panels, so that no curve is covered.

use std::sync::Arc;

use kuva::backend::svg::SvgBackend;
use kuva::plot::scatter::ScatterPlot;
use kuva::plot::{LinePlot, LineStyle};
use kuva::render::layout::{Layout, TickFormat};
use kuva::render::plots::Plot;
use kuva::render::render::{Primitive, Scene, TextAnchor, render_multiple};
use kuva::render::render_utils::wrap_text;
use kuva::render::theme::Theme;

use super::axis;
use super::figure::{Figure, Panel, Scale, Series, Style};
use super::palette::colour;
use super::points::{Point, points, range};

/// Width of the drawing, in px as all lengths here: 190 mm at 96 dpi, a page without its margins.
const WIDTH: f64 = 720.0;
/// Room for the labels of the y axes, the same in all panels so that these stand flush.
const LEFT: f64 = 78.0;
const RIGHT: f64 = 22.0;
/// Room for the tick labels and the label of the x axis, below the last panel.
const BOTTOM: f64 = 43.0;
/// Room between two panels; half of it lets the topmost tick label stand out of the axes.
const GAP: f64 = 14.0;
const ONE_PANEL: f64 = 320.0;
const SEVERAL_PANELS: f64 = 190.0;
const LINE_WIDTH: f64 = 1.6;
const DASHES: &str = "7 4";
/// Columns of samples that are told apart: about one a pixel of the axis.
const COLUMNS: usize = 600;
const TITLE_SIZE: u32 = 15;
const TEXT_SIZE: u32 = 12;
/// The mean width of a letter of running text in units of its size, in the widest of the fonts.
const LETTER: f64 = 0.6;

/// The SVG of a figure: a complete XML document but for the prologue, fit to stand in HTML as well.
pub fn render(figure: &Figure) -> String {
    let mut scene = Scene::new(WIDTH, 0.0);
    scene.font_family = Some("DejaVu Sans, Verdana, Liberation Sans, Arial, sans-serif".into());
    scene.text_color = Some("#222222".into());
    let mut y = header(&mut scene, figure);
    y = legend(&mut scene, figure, y);
    panels(&mut scene, figure, &mut y);
    scene.height = y;
    let svg = SvgBackend::new().render_scene(&scene);
    // With a view box the drawing scales with its surroundings.
    let root = format!(r#"<svg viewBox="0 0 {WIDTH} {y}" role="img" "#);
    svg.replacen("<svg ", &root, 1)
}

/// Text that reaches the SVG as it is: `kuva` takes `$` for mathematics, and XML knows no controls.
fn plain(text: &str) -> String {
    text.chars()
        .filter(|c| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}'))
        .collect::<String>()
        .replace('$', "\\$")
}

fn text(scene: &mut Scene, (x, y): Point, content: &str, size: u32) {
    scene.add(Primitive::Text {
        x,
        y,
        content: plain(content),
        size,
        anchor: TextAnchor::Start,
        rotate: None,
        bold: size == TITLE_SIZE,
        color: None,
    });
}

/// About how wide a label is, in DejaVu Sans, the widest of the fonts.
fn text_width(label: &str) -> f64 {
    let letter = |c: char| match c {
        'm' | 'w' | 'M' | 'W' | '%' | '@' => 0.97,
        'A'..='Z' => 0.72,
        'f' | 'i' | 'j' | 'l' | 'r' | 't' | 'I' | ' ' | ',' | '.' | '-' | '(' | ')' => 0.4,
        _ if c.is_ascii() => 0.62,
        _ => 1.0,
    };
    label.chars().map(letter).sum::<f64>() * f64::from(TEXT_SIZE)
}

/// Draws title and warnings, and tells the y below them.
fn header(scene: &mut Scene, figure: &Figure) -> f64 {
    let mut y = 6.0;
    let warnings = figure
        .warnings
        .iter()
        .map(|w| (format!("Warning: {w}"), TEXT_SIZE));
    for (content, size) in [(figure.title.clone(), TITLE_SIZE)]
        .into_iter()
        .chain(warnings)
    {
        let letters = (WIDTH - 2.0 * RIGHT) / (f64::from(size) * LETTER);
        for line in wrap_text(&content, letters as usize) {
            y += 1.35 * f64::from(size);
            text(scene, (RIGHT, y), &line, size);
        }
    }
    y + 6.0
}

/// The series of all panels, each once.
fn entries(figure: &Figure) -> Vec<&Series> {
    let mut entries: Vec<&Series> = Vec::new();
    for series in figure.panels.iter().flat_map(|p| &p.series) {
        let same = |s: &&Series| (&s.label, s.colour) == (&series.label, series.colour);
        if !entries.iter().any(same) {
            entries.push(series);
        }
    }
    entries
}

/// Draws the legend in as many rows as it needs, and tells the y below it.
fn legend(scene: &mut Scene, figure: &Figure, top: f64) -> f64 {
    const SWATCH: f64 = 26.0;
    const ROW: f64 = 18.0;
    let entries = entries(figure);
    if entries.is_empty() {
        return top;
    }
    let (mut x, mut y) = (LEFT, top + ROW - 5.0);
    for series in entries {
        let width = SWATCH + 6.0 + text_width(&series.label);
        if x > LEFT && x + width > WIDTH - RIGHT {
            (x, y) = (LEFT, y + ROW);
        }
        swatch(scene, series, (x, y - 4.0), SWATCH);
        text(scene, (x + SWATCH + 6.0, y), &series.label, TEXT_SIZE);
        x += width + 16.0;
    }
    y + 5.0
}

fn swatch(scene: &mut Scene, series: &Series, (x, y): Point, width: f64) {
    let stroke = colour(series.colour);
    scene.add(if series.style == Style::Points {
        Primitive::Circle {
            cx: x + width / 2.0,
            cy: y,
            r: 3.0,
            fill: stroke.into(),
            fill_opacity: None,
            stroke: None,
            stroke_width: None,
        }
    } else {
        Primitive::Line {
            x1: x,
            y1: y,
            x2: x + width,
            y2: y,
            stroke: stroke.into(),
            stroke_width: LINE_WIDTH + 0.4,
            stroke_dasharray: (series.style == Style::Dashed).then(|| DASHES.into()),
        }
    });
}

/// Draws the panels one below the other and moves `y` below them.
fn panels(scene: &mut Scene, figure: &Figure, y: &mut f64) {
    let curves: Vec<Vec<Vec<Point>>> = figure
        .panels
        .iter()
        .map(|p| {
            let of = |s| points(s, figure.x_scale, p.y_scale, COLUMNS);
            p.series.iter().map(of).collect()
        })
        .collect();
    let all_x = curves.iter().flatten().flatten().map(|p| p.0);
    let x_ends = axis::ends(range(all_x), figure.x_scale, 0.0);
    for (i, (panel, curves)) in figure.panels.iter().zip(&curves).enumerate() {
        let last = i + 1 == figure.panels.len();
        let plot_height = if figure.panels.len() == 1 {
            ONE_PANEL
        } else {
            SEVERAL_PANELS
        };
        let height = plot_height + GAP / 2.0 + if last { BOTTOM } else { GAP / 2.0 };
        let layout = layout(figure, panel, x_ends, curves, last).with_height(height);
        let drawing = render_multiple(plots(panel, curves), layout);
        scene.add(Primitive::GroupStart {
            transform: Some(format!("translate(0,{y})")),
            title: None,
            extra_attrs: None,
        });
        // The axes enclose all data. Without clipping there is no id that two figures of a page share.
        let clip = |e: &Primitive| matches!(e, Primitive::ClipStart { .. } | Primitive::ClipEnd);
        let drawn = drawing.elements.into_iter().filter(|e| !clip(e));
        drawn.for_each(|e| scene.add(e));
        if curves.iter().all(Vec::is_empty) {
            text(scene, (LEFT + 12.0, GAP / 2.0 + 22.0), "no data", TEXT_SIZE);
        }
        scene.add(Primitive::GroupEnd);
        *y += height;
    }
}

/// The axes of a panel. Only the last panel labels its x axis: the others share it.
fn layout(
    figure: &Figure,
    panel: &Panel,
    x: (f64, f64),
    curves: &[Vec<Point>],
    last: bool,
) -> Layout {
    let data = range(curves.iter().flatten().map(|p| p.1));
    let stepped = panel
        .y_step
        .and_then(|step| Some((axis::by_steps(data?, step)?, step)));
    let y = stepped.map_or_else(|| axis::ends(data, panel.y_scale, 0.05), |(ends, _)| ends);
    let theme = Theme {
        grid_color: "#e4e4e4".into(),
        ..Theme::light()
    };
    let mut layout = Layout::new(x, y)
        .with_width(WIDTH)
        .with_force_margins(LEFT, RIGHT)
        .with_force_margins_y(GAP / 2.0, if last { BOTTOM } else { GAP / 2.0 })
        .with_x_axis_min(x.0)
        .with_x_axis_max(x.1)
        .with_y_axis_min(y.0)
        .with_y_axis_max(y.1)
        .with_y_label(plain(&panel.y_label))
        .with_y_label_wrap((SEVERAL_PANELS / (f64::from(TEXT_SIZE) * LETTER)) as usize)
        .with_box_axes()
        .with_theme(theme)
        .with_label_size(TEXT_SIZE)
        .with_tick_size(TEXT_SIZE - 1)
        // As many as the length of the axis allows.
        .with_ticks(0);
    if let Some((_, step)) = stepped {
        layout = layout.with_y_tick_step(step);
    }
    if figure.x_scale == Scale::Log {
        let ticks = TickFormat::Custom(Arc::new(log_tick));
        layout = layout.with_log_x().with_x_tick_format(ticks);
    }
    if panel.y_scale == Scale::Log {
        let ticks = TickFormat::Custom(Arc::new(log_tick));
        layout = layout.with_log_y().with_y_tick_format(ticks);
    }
    if last {
        layout = layout.with_x_label(plain(&figure.x_label));
    } else {
        layout.suppress_x_ticks = true;
    }
    layout.show_legend = false;
    layout
}

/// A tick of a logarithmic axis: 0.1, 0.2, 0.5, 1 ... without the noise of the powers of ten.
fn log_tick(value: f64) -> String {
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    if (1e-4..1e6).contains(&rounded) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

/// The curves of a panel: one line for each stretch without gap, a dot for a lone point.
fn plots(panel: &Panel, curves: &[Vec<Point>]) -> Vec<Plot> {
    let mut plots = Vec::new();
    for (series, curve) in panel.series.iter().zip(curves) {
        let mut lone = Vec::new();
        for run in curve.split(|p| p.1.is_nan()) {
            if run.len() < 2 || series.style == Style::Points {
                lone.extend_from_slice(run);
            } else {
                plots.push(Plot::Line(line(series, run)));
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

fn line(series: &Series, run: &[Point]) -> LinePlot {
    let line = LinePlot::new()
        .with_data(run.iter().copied())
        .with_color(colour(series.colour))
        .with_stroke_width(LINE_WIDTH);
    match series.style {
        Style::Step => line.with_step(),
        Style::Dashed => line.with_line_style(LineStyle::Custom(DASHES.into())),
        Style::Line | Style::Points => line,
    }
}
