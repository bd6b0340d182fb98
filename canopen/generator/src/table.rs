//! The const table.

use std::fmt::Write;

use crate::parse::integer;
use crate::row::{Access, Default, Flag, Kind, Row};

/// Rust source of the constants `ENTRIES`, `TEXTS` and `RELATIONS`.
#[must_use]
pub fn table(rows: &[Row]) -> String {
    let mut out = format!("// {}\n\n", crate::HEAD);
    out.push_str(
        "use canopen::dictionary::{Access, Address, DataType, Entry, Limits, Mapping, Relation, Text};\n\n",
    );
    out.push_str("#[rustfmt::skip]\npub(super) const ENTRIES: &[Entry] = &[\n");
    for row in rows {
        writeln!(out, "    {},", entry(row)).expect("a string takes all");
    }
    out.push_str("];\n\n#[rustfmt::skip]\npub(super) const TEXTS: &[Text] = &[\n");
    for row in rows {
        if let Default::Text(text) = &row.default {
            let address = address(row.index, row.sub_index());
            writeln!(out, "    Text {{ address: {address}, text: {text:?} }},").expect("a string");
        }
    }
    out.push_str("];\n\n#[rustfmt::skip]\npub(super) const RELATIONS: &[Relation] = &[\n");
    for row in rows {
        if let Some((index, sub)) = row.not_above {
            let (lower, upper) = (address(row.index, row.sub_index()), address(index, sub));
            writeln!(out, "    Relation {{ lower: {lower}, upper: {upper} }},").expect("a string");
        }
    }
    out.push_str("];\n");
    out
}

fn address(index: u16, sub: u8) -> String {
    format!("Address::new(0x{index:04X}, {sub})")
}

fn entry(row: &Row) -> String {
    let access = match (row.access, row.flag) {
        (Access::Const, _) | (Access::Ro, Flag::Fixed) => "Const",
        (Access::Ro, _) => "Read",
        (Access::Wo, _) => "Write",
        (Access::Rw | Access::Rww, _) => "ReadWrite",
    };
    let (index, sub, kind) = (row.index, row.sub_index(), row.kind.name());
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

fn limits(kind: Kind, low: &str, high: &str) -> String {
    let integers = || (integer(low).unwrap_or(0), integer(high).unwrap_or(0));
    match kind {
        Kind::F32 => {
            let real = |text: &str| text.parse::<f32>().unwrap_or(0.0);
            format!("real({:?}, {:?})", real(low), real(high))
        }
        Kind::I8 | Kind::I16 | Kind::I32 | Kind::I64 => {
            let (low, high) = integers();
            format!("signed({low}, {high})")
        }
        _ => {
            let (low, high) = integers();
            format!("unsigned({low}, {high})")
        }
    }
}
