//! The part above the panels: title, warnings and legend.

use kuva::render::render::{Primitive, Scene, TextAnchor};
use kuva::render::render_utils::wrap_text;

use super::{DASHES, LEFT, LETTER, LINE_WIDTH, RIGHT, Size, TEXT_SIZE};
use crate::plot::figure::{Figure, Series, Style};
use crate::plot::palette::colour;
use crate::plot::points::Point;

/// Removes characters that XML does not allow: control characters and two noncharacters.
pub(super) fn printable(text: &str) -> String {
    let known = |c: &char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
    text.chars().filter(known).collect()
}

/// Escapes text for `kuva`, which interprets `$` as the start of a formula.
pub(super) fn plain(text: &str) -> String {
    printable(text).replace('$', "\\$")
}

/// Draws a line of text that starts at this point.
pub(super) fn text(scene: &mut Scene, (x, y): Point, content: &str, size: u32) {
    scene.add(Primitive::Text {
        x,
        y,
        content: plain(content),
        size,
        anchor: TextAnchor::Start,
        rotate: None,
        bold: size > TEXT_SIZE,
        color: None,
    });
}

/// Approximate width of a label in DejaVu Sans, the widest of the fonts.
fn text_width(label: &str) -> f64 {
    let letter = |c: char| match c {
        'm' | 'w' | 'M' | 'W' | '%' | '@' => 0.97,
        'f' | 'i' | 'j' | 'l' | 'r' | 't' | ' ' | ',' | '.' | '-' | '(' | ')' => 0.4,
        'A'..='Z' => 0.72,
        _ if c.is_ascii() => 0.62,
        _ => 1.0,
    };
    label.chars().map(letter).sum::<f64>() * f64::from(TEXT_SIZE)
}

/// Draws title and warnings and returns the y below them.
pub(super) fn header(scene: &mut Scene, figure: &Figure, size: &Size) -> f64 {
    let mut y = 6.0;
    let warning = |w| (format!("Warning: {w}"), TEXT_SIZE);
    let warnings = figure.warnings.iter().map(warning);
    let title = std::iter::once((figure.title.clone(), size.title));
    for (content, text_size) in title.chain(warnings) {
        let letters = (size.width - 2.0 * RIGHT) / (f64::from(text_size) * LETTER);
        for line in wrap_text(&content, letters as usize) {
            y += 1.35 * f64::from(text_size);
            text(scene, (RIGHT, y), &line, text_size);
        }
    }
    y + 6.0
}

/// The series of all panels without duplicates.
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

/// Draws the legend in as many rows as required and returns the y below it.
pub(super) fn legend(scene: &mut Scene, figure: &Figure, size: &Size, top: f64) -> f64 {
    const SWATCH: f64 = 26.0;
    const ROW: f64 = 18.0;
    let entries = entries(figure);
    if entries.is_empty() {
        return top;
    }
    let (mut x, mut y) = (LEFT, top + ROW - 5.0);
    for series in entries {
        let width = SWATCH + 6.0 + text_width(&series.label);
        if x > LEFT && x + width > size.width - RIGHT {
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
