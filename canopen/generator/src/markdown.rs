//! The documentation.

use std::fmt::Write;

use crate::row::{Access, Default, Flag, Row};
use crate::value::Relation;

const CONVENTIONS: &str = "
Column *value*: default, [range], unit. *RPDO* and *TPDO*: can be mapped to them. *Locked*: not
writable while the drive is enabled, or without the service password where one is set. Sub-index 0
of a record or array is a constant, the highest sub-index supported, where it is not listed. Objects
that differ in their defaults alone share rows: one default for each object, or one for all.
";

/// Markdown: one table for each area of the dictionary.
#[must_use]
pub fn markdown(title: &str, rows: &[Row]) -> String {
    let mut out = format!("<!-- {} -->\n# {title}\n{CONVENTIONS}", crate::HEAD);
    for (name, low, high) in [
        ("Communication", 0x1000, 0x1FFF),
        ("Manufacturer", 0x2000, 0x5FFF),
        ("Device profile", 0x6000, 0x9FFF),
    ] {
        write!(out, "\n## {name} ({low:04X}h to {high:04X}h)\n\n").expect("a string");
        out.push_str("| index, sub | name | type, access | value | meaning |\n");
        out.push_str("|---|---|---|---|---|\n");
        let area: Vec<_> = rows
            .iter()
            .filter(|row| (low..=high).contains(&row.index))
            .cloned()
            .collect();
        let objects: Vec<_> = crate::objects(&area).collect();
        for alike in objects.chunk_by(|one, next| are_alike(one, next)) {
            describe(&mut out, alike);
        }
    }
    out
}

/// Whether two objects differ in index, numbers in their names, and defaults alone.
fn are_alike(one: &[Row], next: &[Row]) -> bool {
    let name = |object: &str| object.replace(|c: char| c.is_ascii_digit(), "");
    let is_alike = |(row, other): (&Row, &Row)| {
        let expected = Row {
            index: row.index + 1,
            object: other.object.clone(),
            default: other.default.clone(),
            ..row.clone()
        };
        *other == expected && name(&row.object) == name(&other.object)
    };
    one[0].sub.is_some() && one.len() == next.len() && one.iter().zip(next).all(is_alike)
}

/// The rows of objects that are alike; entries that differ in their number alone share a row.
fn describe(out: &mut String, objects: &[&[Row]]) {
    let (first, last) = (&objects[0][0], &objects[objects.len() - 1][0]);
    let mut index = format!("{:04X}h", first.index);
    if first.sub.is_none() {
        write_entry(out, &index, &format!("**{}**", first.object), &[first]);
        return;
    }
    let mut name = format!("**{}**", first.object);
    if last.index > first.index {
        write!(index, " to {:04X}h", last.index).expect("a string");
        write!(name, " to **{}**", last.object).expect("a string");
    }
    writeln!(out, "| {index} | {name} ||||").expect("a string");
    // Each entry with the same one of the other objects.
    let entries = (0..objects[0].len()).map(|at| objects.iter().map(|o| &o[at]).collect());
    let entries: Vec<Vec<&Row>> = entries
        .filter(|rows: &Vec<&Row>| rows[0].sub != Some(0) || rows[0].access != Access::Const)
        .collect();
    let are_repeated = |one: &Vec<&Row>, next: &Vec<&Row>| {
        let mut pairs = one.iter().zip(next);
        pairs.all(|(row, other)| is_repeated(row, other))
    };
    for entries in entries.chunk_by(are_repeated) {
        let (rows, last) = (&entries[0], entries[entries.len() - 1][0]);
        let (mut sub, mut name) = (
            format!("{:02X}h", rows[0].sub_index()),
            rows[0].entry.clone(),
        );
        if let (Some((_, number)), true) = (numbered(last), entries.len() > 1) {
            write!(sub, " to {:02X}h", last.sub_index()).expect("a string");
            write!(name, " to {number}").expect("a string");
        }
        write_entry(out, &sub, &name, rows);
    }
}

/// A row of the table for an entry of one object or of several that are alike.
fn write_entry(out: &mut String, address: &str, name: &str, rows: &[&Row]) {
    let (kind, access) = (rows[0].kind.standard_name(), access(rows[0]));
    let mut values: Vec<_> = rows.iter().map(|row| value(row)).collect();
    if values.iter().all(|value| *value == values[0]) {
        values.truncate(1);
    }
    let (values, meaning) = (values.join("; "), meaning(rows[0]));
    writeln!(
        out,
        "| {address} | {name} | {kind} {access} | {values} | {meaning} |"
    )
    .expect("a string");
}

/// Name and number of an entry such as `Application object 3`.
fn numbered(row: &Row) -> Option<(&str, u8)> {
    let (name, number) = row.entry.rsplit_once(' ')?;
    Some((name, number.parse().ok()?))
}

/// Whether `next` differs from `row` by one in sub-index and number, and in nothing else.
fn is_repeated(row: &Row, next: &Row) -> bool {
    let (Some((name, number)), Some(following)) = (numbered(row), numbered(next)) else {
        return false;
    };
    let expected = Row {
        sub: Some(row.sub_index() + 1),
        entry: next.entry.clone(),
        ..row.clone()
    };
    following == (name, number + 1) && *next == expected
}

fn access(row: &Row) -> String {
    let mapped = match (row.mappable, row.access) {
        (false, _) => "",
        (true, Access::Rww) => ", RPDO",
        (true, _) => ", TPDO",
    };
    let is_locked = row.flag == Flag::Locked;
    let locked = if is_locked { ", locked" } else { "" };
    format!("{}{mapped}{locked}", row.access.name())
}

/// Default, range and unit.
fn value(row: &Row) -> String {
    let default = match &row.default {
        Default::None => String::new(),
        Default::Integer(_, text) | Default::Text(text) => text.clone(),
        Default::NodeId(value) => format!("node-ID+0x{value:X}"),
        Default::Real(value) => format!("{value:?}"),
    };
    let range = row.limits.as_ref();
    let range = range.map_or(String::new(), |(low, high)| format!("[{low}, {high}]"));
    let is_scaled = row.unit.starts_with(|c: char| c.is_ascii_digit());
    let unit = if is_scaled {
        format!("in {}", row.unit)
    } else {
        row.unit.clone()
    };
    let mut parts = vec![default, range, unit];
    parts.retain(|part| !part.is_empty());
    parts.join(" ")
}

fn meaning(row: &Row) -> String {
    let relation = match &row.relation {
        Some(Relation::Below((index, sub))) => format!("below {index:04X}h:{sub:02X}"),
        Some(Relation::NotAbove((index, sub))) => format!("not above {index:04X}h:{sub:02X}"),
        Some(Relation::OneOf(values)) => {
            let values: Vec<_> = values.iter().map(i32::to_string).collect();
            format!("one of {}", values.join(", "))
        }
        None => String::new(),
    };
    let mut parts = vec![row.meaning.clone(), relation];
    parts.retain(|part| !part.is_empty() && *part != row.entry);
    parts.join("; ")
}
