//! The storage of parameters and other values.

use std::fmt::Write;

use crate::parse::integer;
use crate::row::{DataType, Default, Row};
use crate::value::{Relation, StorageLocation, ValuePath};

/// A group of stored fields.
#[derive(Clone, Copy, Debug)]
pub struct Group {
    location: StorageLocation,
    name: &'static str,
    type_name: &'static str,
    doc: &'static str,
}

impl Group {
    /// The group `name` of a store, with the name of its struct and a sentence about it.
    #[must_use]
    pub const fn new(
        location: StorageLocation,
        name: &'static str,
        type_name: &'static str,
        doc: &'static str,
    ) -> Self {
        Self {
            location,
            name,
            type_name,
            doc,
        }
    }
}

/// A declared field.
type Field<'a> = (&'a Row, &'a ValuePath);

/// Rust source of a struct for each group and each of the two stores, of the enums of their
/// fields, and of the relations between them.
///
/// # Panics
///
/// A path has a group that `groups` does not have.
#[must_use]
pub fn storage(groups: &[Group], rows: &[Row]) -> String {
    let mut out = format!("// {}\n\nuse super::CONTROL_DEFAULT;\n", crate::HEAD);
    out.push_str("use model_core::control::cascade::Coefficients;\n");
    let fields: Vec<Field> = crate::declarations(rows).collect();
    for (row, path) in &fields {
        let is_group = |group: &Group| group.location == path.location && group.name == path.group;
        assert!(groups.iter().any(is_group), "{}: no such group", row.entry);
    }
    for group in groups {
        let is_its = |field: &&Field| {
            (field.1.location, field.1.group.as_str()) == (group.location, group.name)
        };
        let fields: Vec<Field> = fields.iter().filter(is_its).copied().collect();
        group_struct(&mut out, group, &fields);
    }
    for (location, name, entry, docs) in STORES {
        let is_its = |field: &&Field| field.1.location == location;
        let fields: Vec<Field> = fields.iter().filter(is_its).copied().collect();
        let groups: Vec<&Group> = groups
            .iter()
            .filter(|group| group.location == location)
            .collect();
        store_struct(&mut out, (location, name, docs[0]), &groups);
        write!(
            out,
            "\nentries! {{\n    /// {}\n    {entry} of {name} {{\n",
            docs[1]
        )
        .expect("a string");
        for (row, path) in &fields {
            let variant = crate::camel_case(&path.field);
            let (group, field, ty) = (&path.group, &path.field, rust_type(row, path));
            let range = range(row);
            writeln!(out, "        {variant}: {group}.{field} as {ty}{range},").expect("a string");
        }
        out.push_str("    }\n}\n");
        relations(&mut out, (name, entry), &fields, rows);
    }
    out
}

/// The range as `entries!` takes it.
fn range(row: &Row) -> String {
    let Some((low, high)) = &row.limits else {
        return String::new();
    };
    let bound = |text: &String| match row.kind {
        DataType::F32 => format!("{:?}", text.parse::<f32>().unwrap_or(0.0)),
        _ => integer(text).unwrap_or(0).to_string(),
    };
    format!(" in {}..={}", bound(low), bound(high))
}

/// Store, struct, enum of its fields, and the documentation of both.
const STORES: [(StorageLocation, &str, &str, [&str; 2]); 2] = [
    (
        StorageLocation::Parameters,
        "BoardParameters",
        "Parameter",
        [
            "All parameters of the board's application.",
            "An integer parameter of the board.",
        ],
    ),
    (
        StorageLocation::Values,
        "ObjectValues",
        "ObjectValue",
        [
            "Values of objects that a master sets and the drive stores beside the parameters of the board.",
            "A value of [`ObjectValues`].",
        ],
    ),
];

/// The parameters of the board are 32-bit integers, independently of the types of their objects.
fn rust_type(row: &Row, path: &ValuePath) -> &'static str {
    match path.location {
        StorageLocation::Parameters => "i32",
        _ => row.kind.rust_name(),
    }
}

fn derives(has_real: bool) -> &'static str {
    if has_real {
        "#[derive(Debug, Clone, Copy, PartialEq)]"
    } else {
        "#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]"
    }
}

fn group_struct(out: &mut String, group: &Group, fields: &[Field]) {
    let has_real = fields.iter().any(|(row, _)| row.kind == DataType::F32);
    let (name, derives) = (group.type_name, derives(has_real));
    write!(
        out,
        "\n/// {}\n{derives}\npub struct {name} {{\n",
        group.doc
    )
    .expect("a string");
    for (row, path) in fields {
        out.push_str(&crate::doc_comment("    ", &description(row)));
        writeln!(out, "    pub {}: {},", path.field, rust_type(row, path)).expect("a string");
    }
    write!(
        out,
        "}}\n\nimpl {name} {{\n    /// The defaults.\n    pub const DEFAULT: Self = Self {{\n"
    )
    .expect("a string");
    for (row, path) in fields {
        let default = match &row.default {
            Default::Integer(value, _) => value.to_string(),
            Default::Real(value) => format!("{value:?}"),
            _ => "0".to_string(),
        };
        writeln!(out, "        {}: {default},", path.field).expect("a string");
    }
    out.push_str("    };\n}\n");
}

/// Meaning, unit, default with its source, range and address in one paragraph.
fn description(row: &Row) -> String {
    let meaning = if row.meaning.is_empty() {
        &row.entry
    } else {
        &row.meaning
    };
    let mut text = format!("{meaning}.");
    if !row.unit.is_empty() {
        write!(text, " Unit: {}.", row.unit).expect("a string");
    }
    match &row.default {
        Default::Integer(value, _) => write!(text, " Default: {value}"),
        Default::Real(value) => write!(text, " Default: {value:?}"),
        _ => write!(text, " Default: 0"),
    }
    .expect("a string");
    if !row.source.is_empty() {
        write!(text, " ({})", row.source).expect("a string");
    }
    text.push('.');
    if let Some((low, high)) = &row.limits {
        write!(text, " Range: {low} to {high}.").expect("a string");
    }
    write!(text, " Object {}.", crate::title(row)).expect("a string");
    text
}

fn store_struct(
    out: &mut String,
    (location, name, doc): (StorageLocation, &str, &str),
    groups: &[&Group],
) {
    let has_control = location == StorageLocation::Parameters;
    let derives = derives(!has_control);
    write!(out, "\n/// {doc}\n{derives}\npub struct {name} {{\n").expect("a string");
    if has_control {
        out.push_str(
            "    /// Gains and limits of the control step.\n    pub control: Coefficients,\n",
        );
    }
    for group in groups {
        writeln!(out, "    /// {}", group.doc).expect("a string");
        writeln!(out, "    pub {}: {},", group.name, group.type_name).expect("a string");
    }
    write!(
        out,
        "}}\n\nimpl {name} {{\n    /// The defaults.\n    pub const DEFAULT: Self = Self {{\n"
    )
    .expect("a string");
    if has_control {
        out.push_str("        control: CONTROL_DEFAULT,\n");
    }
    for group in groups {
        writeln!(out, "        {}: {}::DEFAULT,", group.name, group.type_name).expect("a string");
    }
    out.push_str("    };\n}\n");
}

fn relations(out: &mut String, (name, entry): (&str, &str), fields: &[Field], rows: &[Row]) {
    write!(
        out,
        "\nimpl {name} {{\n    /// The first value that breaks a relation.\n    \
         pub(super) fn broken_relation(&self) -> Option<{entry}> {{\n"
    )
    .expect("a string");
    let field = |(index, sub): (u16, u8)| {
        let row = rows.iter().find(|row| row.address() == (index, sub));
        let path = row
            .and_then(|row| row.value.as_ref())
            .filter(|path| path.location.is_stored());
        let path = path.unwrap_or_else(|| panic!("{index:04X}h:{sub:02X}: no stored value"));
        format!("self.{}.{}", path.group, path.field)
    };
    for (row, path) in fields {
        let value = field(row.address());
        let is_broken = match &row.relation {
            None => continue,
            Some(Relation::Below(upper)) => format!("{value} >= {}", field(*upper)),
            Some(Relation::NotAbove(upper)) => format!("{value} > {}", field(*upper)),
            Some(Relation::OneOf(values)) => {
                let values: Vec<_> = values.iter().map(i32::to_string).collect();
                format!("!matches!({value}, {})", values.join(" | "))
            }
        };
        let variant = crate::camel_case(&path.field);
        writeln!(
            out,
            "        if {is_broken} {{\n            return Some({entry}::{variant});\n        }}"
        )
        .expect("a string");
    }
    out.push_str("        None\n    }\n}\n");
}
