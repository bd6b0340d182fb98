//! The schematic as SVG: a panel for each block, parts with the names of the nets at their pins.

use std::fmt::Write as _;

use super::bom;
use super::symbols::{Side, Symbol, stacked, two_terminal};
use crate::{Design, Electrical, Part, PinOf};

const WIDTH: i32 = 1640;
const MARGIN: i32 = 20;
const PANEL: i32 = (WIDTH - 3 * MARGIN) / 2;
const TITLE: i32 = 34;
/// A part with two terminals.
const CELL: (i32, i32) = (PANEL / 3, 52);
/// Between two pins of a part with more.
const PITCH: i32 = 18;
/// Two lines above the drawing of a part.
const HEADING: i32 = 36;

const STYLE: &str = "text{font:12px sans-serif;fill:#222}.t{font:bold 15px sans-serif}.d{font-weight:bold}\
.s{fill:#777;font-size:11px}.vm,.v5,.v3{font-weight:bold}.vm{fill:#b00020}.v5{fill:#b45309}.v3{fill:#9a3412}\
.g{fill:#1d4ed8}.e{text-anchor:end}.m{text-anchor:middle}path,rect,circle{stroke:#333;stroke-width:1.4;fill:none}\
.p{stroke:#bbb;fill:#fcfcfc}.b{fill:#fff8e1}.f{fill:#333}";

pub(super) fn drawing(design: &Design, board: &str) -> String {
    let mut groups: Vec<(&str, Vec<&Part>)> = Vec::new();
    for part in design.parts.iter().filter(|part| part.board == board) {
        match groups.iter_mut().find(|(name, _)| *name == part.group) {
            Some((_, parts)) => parts.push(part),
            None => groups.push((&part.group, vec![part])),
        }
    }
    // Each panel goes to the shorter column.
    let mut columns = [MARGIN; 2];
    let mut panels = String::new();
    for (name, parts) in groups {
        let column = usize::from(columns[1] < columns[0]);
        let (panel, height) = panel(design, name, &parts);
        let x = MARGIN + column as i32 * (PANEL + MARGIN);
        let _ = writeln!(
            panels,
            "<g transform=\"translate({x} {})\">\n{panel}</g>",
            columns[column]
        );
        columns[column] += height + MARGIN;
    }
    let height = columns[0].max(columns[1]);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" role=\"img\">\n\
         <title>Schematic of the {board} board</title>\n<style>{STYLE}</style>\n\
         <rect width=\"{WIDTH}\" height=\"{height}\" style=\"fill:#fff;stroke:none\"/>\n{panels}</svg>\n"
    )
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

/// Class of a net's name: supplies and ground are highlighted.
fn class(net: &str) -> &'static str {
    match net {
        "VM" | "VF" | "VIN_M" => "vm",
        "5V" => "v5",
        "3V3" => "v3",
        "GND" => "g",
        _ => "n",
    }
}

fn text(out: &mut String, x: i32, y: i32, class: &str, content: &str) {
    let _ = writeln!(
        out,
        "<text x=\"{x}\" y=\"{y}\" class=\"{class}\">{}</text>",
        escaped(content)
    );
}

fn panel(design: &Design, name: &str, parts: &[&Part]) -> (String, i32) {
    let mut out = String::new();
    text(&mut out, 12, 23, "t", name);
    let (small, large): (Vec<&Part>, Vec<&Part>) = parts
        .iter()
        .copied()
        .partition(|part| two_terminal(part).is_some());
    let is_drawn = |part: &&&Part| !design.pins_of(part).is_empty();
    let mut y = TITLE;
    let mut row = Vec::new();
    for part in large.iter().filter(is_drawn) {
        row.push(*part);
        if row.len() == 2 {
            y += boxes(design, &mut out, &row, y);
            row.clear();
        }
    }
    y += boxes(design, &mut out, &row, y);
    for (index, part) in small.iter().enumerate() {
        let x = (index % 3) as i32 * CELL.0;
        terminals(design, &mut out, part, x, y + (index / 3) as i32 * CELL.1);
    }
    y += small.len().div_ceil(3) as i32 * CELL.1;
    let mechanical: Vec<_> = large.iter().filter(|part| !is_drawn(part)).collect();
    for part in mechanical {
        y += PITCH;
        let words = format!(
            "{}: {}, {}",
            part.designator, part.part_number, part.purpose
        );
        text(&mut out, 16, y, "s", &words);
    }
    y += 12;
    let frame = format!("<rect class=\"p\" width=\"{PANEL}\" height=\"{y}\" rx=\"6\"/>\n");
    (frame + &out, y)
}

fn terminals(design: &Design, out: &mut String, part: &Part, x: i32, y: i32) {
    let Some(symbol) = two_terminal(part) else {
        return;
    };
    let (middle, line) = (x + CELL.0 / 2, y + 32);
    let value = bom::value(part);
    let value = if value.is_empty() {
        part.kind.clone()
    } else {
        value
    };
    text(out, middle - 22, y + 14, "d e", &part.designator);
    text(out, middle - 16, y + 14, "n", &value);
    let _ = writeln!(
        out,
        "<g transform=\"translate({middle} {line})\">{symbol}</g>"
    );
    for (pin, x, side) in [("1", middle - 50, " e"), ("2", middle + 50, "")] {
        let net = design
            .net_at(&part.designator, pin)
            .map_or("?", |net| net.name.as_str());
        text(out, x, line + 4, &format!("{}{side}", class(net)), net);
    }
}

/// Whether a pin is at the right side of its box.
fn is_right(found: &PinOf<'_>) -> bool {
    use Electrical::{Bus, Drain, OpenDrain, Output, Passive, Supply};
    matches!(
        found.pin.electrical,
        Output | OpenDrain | Supply | Drain | Bus | Passive
    )
}

/// Boxes side by side; returns their height.
fn boxes(design: &Design, out: &mut String, parts: &[&Part], y: i32) -> i32 {
    let mut height = 0;
    for (index, part) in parts.iter().enumerate() {
        let middle = PANEL * (2 * index as i32 + 1) / (2 * parts.len() as i32);
        let drawn = match stacked(part) {
            Some(symbol) => stack(design, out, part, &symbol, middle, y),
            None => chip(design, out, part, middle, y),
        };
        height = height.max(drawn);
    }
    height
}

/// Number and purpose of a part above its drawing.
fn heading(out: &mut String, part: &Part, middle: i32, y: i32) {
    let title = format!("{} {}", part.designator, part.part_number);
    text(out, middle, y + 14, "m d", &title);
    text(out, middle, y + 28, "m s", &part.purpose);
}

/// A part as symbol, with the nets at its terminals; returns its height.
fn stack(
    design: &Design,
    out: &mut String,
    part: &Part,
    symbol: &Symbol,
    middle: i32,
    y: i32,
) -> i32 {
    heading(out, part, middle, y);
    let centre = y + HEADING + symbol.half_height;
    let _ = writeln!(
        out,
        "<g transform=\"translate({middle} {centre})\">{}</g>",
        symbol.svg
    );
    for &(pin, x, below, side) in symbol.terminals {
        let first = pin.split(' ').next().unwrap_or(pin);
        let net = design
            .net_at(&part.designator, first)
            .map_or("?", |net| net.name.as_str());
        let (class, label) = (class(net), format!("{net} ({pin})"));
        let (x, y) = (middle + x, centre + below + 4);
        match side {
            Side::Left => text(out, x - 5, y, &format!("{class} e"), &label),
            Side::Right => text(out, x + 5, y, class, &label),
            Side::End => text(out, x + 6, y, class, &label),
        }
    }
    HEADING + 2 * symbol.half_height + 14
}

fn chip(design: &Design, out: &mut String, part: &Part, middle: i32, y: i32) -> i32 {
    let pins = design.pins_of(part);
    let connected: Vec<_> = pins.iter().filter(|found| found.net.is_some()).collect();
    let (right, left): (Vec<_>, Vec<_>) = connected.into_iter().partition(|found| is_right(found));
    let rows = left.len().max(right.len()) as i32;
    // The pins of the processor's board have long names.
    let width = if rows > 10 { 240 } else { 150 };
    let (x, top) = (middle - width / 2, y + HEADING);
    heading(out, part, middle, y);
    let height = rows * PITCH + 8;
    let _ = writeln!(
        out,
        "<rect class=\"b\" x=\"{x}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/>"
    );
    for (pins, is_right) in [(&left, false), (&right, true)] {
        for (index, found) in pins.iter().enumerate() {
            pin(
                out,
                found,
                middle + if is_right { width / 2 } else { -width / 2 },
                top + 16 + index as i32 * PITCH,
                is_right,
            );
        }
    }
    height + HEADING + 14
}

/// A pin at the edge of its box, with a wire to the name of its net.
fn pin(out: &mut String, found: &PinOf<'_>, edge: i32, y: i32, is_right: bool) {
    let (pin, net) = (&found.pin, found.net.map_or("?", |net| net.name.as_str()));
    let label = if pin.name == pin.pin {
        pin.pin.clone()
    } else {
        format!("{} {}", pin.pin, pin.name)
    };
    let sign = if is_right { 1 } else { -1 };
    let _ = writeln!(out, "<path d=\"M{edge} {}h{}\"/>", y - 4, sign * 22);
    let (inner, outer) = if is_right { ("s e", "") } else { ("s", " e") };
    text(out, edge - sign * 6, y, inner, &label);
    text(
        out,
        edge + sign * 27,
        y,
        &format!("{}{outer}", class(net)),
        net,
    );
}
