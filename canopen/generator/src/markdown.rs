//! The documentation.

use std::fmt::Write;

use crate::row::{Default, Flag, Row};
use crate::value::Relation;

/// Markdown: one table for each area of the dictionary.
#[must_use]
pub fn markdown(title: &str, rows: &[Row]) -> String {
    let mut out = format!("<!-- {} -->\n# {title}\n", crate::HEAD);
    for (name, low, high) in [
        ("Communication", 0x1000, 0x1FFF),
        ("Manufacturer", 0x2000, 0x5FFF),
        ("Device profile", 0x6000, 0x9FFF),
    ] {
        write!(out, "\n## {name} ({low:04X}h to {high:04X}h)\n").expect("a string takes all");
        let area: Vec<_> = rows
            .iter()
            .filter(|row| (low..=high).contains(&row.index))
            .cloned()
            .collect();
        for object in crate::objects(&area) {
            describe(&mut out, object);
        }
    }
    out
}

fn describe(out: &mut String, object: &[Row]) {
    let first = &object[0];
    write!(out, "\n### {:04X}h {}\n\n", first.index, first.object).expect("a string");
    out.push_str("| sub | name | type | access | PDO | default | range | unit | |\n");
    out.push_str("|---|---|---|---|---|---|---|---|---|\n");
    for row in object {
        let sub = row.sub.map_or(String::new(), |sub| format!("{sub:02X}h"));
        let range = row
            .limits
            .as_ref()
            .map_or(String::new(), |(low, high)| format!("{low} to {high}"));
        let mapped = match (row.mappable, row.access) {
            (false, _) => "",
            (true, crate::Access::Rww) => "RPDO",
            (true, _) => "TPDO",
        };
        writeln!(
            out,
            "| {sub} | {} | {} | {} | {mapped} | {} | {range} | {} | {} |",
            row.entry,
            row.kind.standard_name(),
            row.access.name(),
            default(&row.default),
            row.unit,
            remark(row),
        )
        .expect("a string");
    }
}

fn default(default: &Default) -> String {
    match default {
        Default::None => String::new(),
        Default::Integer(_, text) | Default::Text(text) => text.clone(),
        Default::NodeId(value) => format!("node-ID + 0x{value:X}"),
        Default::Real(value) => format!("{value:?}"),
    }
}

fn remark(row: &Row) -> String {
    let mut remarks = Vec::new();
    if row.flag == Flag::Locked {
        remarks.push("not while the drive is enabled or the service password locks it".to_string());
    }
    match &row.relation {
        Some(Relation::Below((index, sub))) => {
            remarks.push(format!("below {index:04X}h:{sub:02X}"));
        }
        Some(Relation::NotAbove((index, sub))) => {
            remarks.push(format!("not above {index:04X}h:{sub:02X}"));
        }
        Some(Relation::OneOf(values)) => {
            let values: Vec<_> = values.iter().map(i32::to_string).collect();
            remarks.push(format!("one of {}", values.join(" and ")));
        }
        None => {}
    }
    if !row.meaning.is_empty() {
        remarks.insert(0, row.meaning.clone());
    }
    remarks.join("; ")
}
