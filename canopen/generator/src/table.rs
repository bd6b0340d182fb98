//! The const table of the dictionary.

use std::fmt::Write;

use crate::parse::integer;
use crate::row::{Access, DataType, Default, Flag, Row};
use crate::value::StorageLocation;

/// Rust source of the constants `OBJECTS`, `TEXTS` and `RELATIONS`, and of the enums `DriveCommand`
/// and `Measured`.
#[must_use]
pub fn table(rows: &[Row]) -> String {
    let mut out = format!("// {}\n\n", crate::HEAD);
    out.push_str(
        "use canopen::dictionary::{Access, Address, DataType, Entry, Limits, Mapping, Relation, Text};\n\
         use model_core::control::parameters::ControlParameters;\n\n\
         use super::Location;\n\
         use crate::parameters::{ObjectValue, Parameter};\n\n",
    );
    let count = rows.len();
    writeln!(
        out,
        "/// Each entry, and where its value lives.\n\
         pub(super) const OBJECTS: [(Entry, Location); {count}] = ["
    )
    .expect("a string takes all");
    let mut communication = 0..;
    for row in rows {
        let location = location(row, &mut communication);
        writeln!(out, "    ({}, {location}),", entry(row)).expect("a string");
    }
    let stored = communication.start;
    write!(
        out,
        "];\n\n/// How many communication parameters are stored.\n\
         pub(crate) const COMMUNICATION: usize = {stored};\n\n\
         pub(super) const TEXTS: &[Text] = &[\n"
    )
    .expect("a string");
    for row in rows {
        if let Default::Text(text) = &row.default {
            let address = address(row.address());
            writeln!(out, "    Text {{ address: {address}, text: {text:?} }},").expect("a string");
        }
    }
    out.push_str("];\n\npub(super) const RELATIONS: &[Relation] = &[\n");
    for row in rows {
        if let Some(upper) = row.upper() {
            let (lower, upper) = (address(row.address()), address(upper));
            writeln!(out, "    Relation {{ lower: {lower}, upper: {upper} }},").expect("a string");
        }
    }
    out.push_str("];\n");
    names(
        &mut out,
        rows,
        "DriveCommand",
        "read and written by code of the drive",
        is_command,
    );
    names(
        &mut out,
        rows,
        "Measured",
        "computed when it is read",
        |row| storage_location(row) == Some(StorageLocation::Measured),
    );
    out
}

fn storage_location(row: &Row) -> Option<StorageLocation> {
    row.value.as_ref().map(|path| path.location)
}

fn is_command(row: &Row) -> bool {
    row.flag == Flag::Hook || storage_location(row) == Some(StorageLocation::Command)
}

/// An enum of the values for which this holds.
fn names(out: &mut String, rows: &[Row], name: &str, what: &str, holds: impl Fn(&Row) -> bool) {
    write!(
        out,
        "\n/// A value that is {what}.\n\
         #[derive(Debug, Clone, Copy, PartialEq, Eq)]\npub enum {name} {{\n"
    )
    .expect("a string");
    let mut seen = Vec::new();
    for row in rows.iter().filter(|row| holds(row)) {
        let Some(path) = row.value.as_ref().filter(|path| !seen.contains(path)) else {
            continue;
        };
        writeln!(out, "    /// {}.", crate::title(row)).expect("a string");
        writeln!(out, "    {},", crate::camel_case(&path.field)).expect("a string");
        seen.push(path);
    }
    out.push_str("}\n");
}

fn location(row: &Row, communication: &mut std::ops::RangeFrom<u8>) -> String {
    let Some(path) = &row.value else {
        // 1003h is the error history, 1010h and 1011h are orders.
        let is_stored = row.access == Access::Rw
            && (0x1000..0x2000).contains(&row.index)
            && !matches!(row.index, 0x1003 | 0x1010 | 0x1011);
        return match is_stored.then(|| communication.next()).flatten() {
            Some(at) => format!("Location::Communication({at})"),
            None => "Location::Server".into(),
        };
    };
    let name = crate::camel_case(&path.field);
    match path.location {
        _ if is_command(row) => format!("Location::Command(DriveCommand::{name})"),
        StorageLocation::Control => format!(
            "Location::Control(ControlParameters::row(\"{}\"))",
            path.field
        ),
        StorageLocation::Parameters => format!("Location::Parameter(Parameter::{name})"),
        StorageLocation::Values => format!("Location::Value(ObjectValue::{name})"),
        StorageLocation::Command => format!("Location::Command(DriveCommand::{name})"),
        StorageLocation::Measured => format!("Location::Measured(Measured::{name})"),
    }
}

fn address((index, sub): (u16, u8)) -> String {
    format!("Address::new(0x{index:04X}, {sub})")
}

fn entry(row: &Row) -> String {
    let access = match (row.access, row.flag) {
        (Access::Const, _) | (Access::Ro, Flag::Fixed) => "Const",
        (Access::Ro, _) => "Read",
        (Access::Wo, _) => "Write",
        (Access::Rw | Access::Rww, _) => "ReadWrite",
    };
    let ((index, sub), kind) = (row.address(), row.kind.name());
    let mut out = format!("Entry::new(0x{index:04X}, {sub}, DataType::{kind}, Access::{access})");
    match &row.default {
        Default::Integer(value, _) if *value != 0 => {
            write!(out, ".value({})", bits(*value, &row.default)).expect("a string");
        }
        Default::NodeId(value) => {
            write!(out, ".value_with_node_id(0x{value:X})").expect("a string")
        }
        Default::Real(value) if *value != 0.0 => {
            write!(out, ".value(f32::to_bits({value:?}))").expect("a string");
        }
        _ => {}
    }
    if row.mappable {
        let mapping = if row.access == Access::Rww {
            "Receive"
        } else {
            "Transmit"
        };
        write!(out, ".mappable(Mapping::{mapping})").expect("a string");
    }
    if let Some((low, high)) = &row.limits {
        write!(out, ".limits(&Limits::{})", limits(row.kind, low, high)).expect("a string");
    }
    if row.flag == Flag::Locked {
        out.push_str(".guarded()");
    }
    out
}

fn bits(value: i128, default: &Default) -> String {
    match default {
        Default::Integer(_, text) if text.starts_with("0x") => format!("0x{value:X}"),
        _ if value < 0 => format!("{value}_i32 as u32"),
        _ => value.to_string(),
    }
}

fn limits(kind: DataType, low: &str, high: &str) -> String {
    let integers = || (integer(low).unwrap_or(0), integer(high).unwrap_or(0));
    match kind {
        DataType::F32 => {
            let real = |text: &str| text.parse::<f32>().unwrap_or(0.0);
            format!("real({:?}, {:?})", real(low), real(high))
        }
        DataType::I8 | DataType::I16 | DataType::I32 | DataType::I64 => {
            let (low, high) = integers();
            format!("signed({low}, {high})")
        }
        _ => {
            let (low, high) = integers();
            format!("unsigned({low}, {high})")
        }
    }
}
