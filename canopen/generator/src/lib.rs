//! One source for an object dictionary: from a CSV file it generates the const table of the crate
//! `canopen`, the storage behind the objects, the electronic data sheet (CiA 306) and the
//! documentation.
//!
//! | column | content |
//! |---|---|
//! | `index`, `sub` | address; an empty `sub` makes the object one variable |
//! | `object`, `entry` | names of the object and of the entry |
//! | `type` | `u8` to `u64`, `i8` to `i64`, `f32`, `str` or `dom` |
//! | `access` | `const`, `ro`, `wo`, `rw`, or `rww` where RPDOs may map it |
//! | `pdo` | `x` where PDOs may map it |
//! | `default`, `min`, `max`, `unit` | of the value |
//! | `flags` | `fixed`, `locked` or `hook`, see below |
//! | `relation` | `<0x2001:5`: below that object; `<=0x607D:2`: not above it; `in 500 1000`: one of these |
//! | `value` | where the value lives, see below |
//! | `meaning`, `source` | meaning of a parameter, and the source of its default |
//!
//! The value of a `fixed` entry is read from the table. A `locked` entry is not writable while the
//! drive is enabled. The value of a `hook` is stored under its path, but code of the drive reads
//! and writes it.
//!
//! The column `value` names one of five places:
//!
//! | path | location |
//! |---|---|
//! | `control.FIELD` | a control parameter; default, range and unit are those of `model-core` |
//! | `parameters.GROUP.FIELD` | an integer parameter of the board |
//! | `values.GROUP.FIELD` | a value that the drive stores in addition to the parameters |
//! | `command.NAME` | a value with an effect: the drive's code reads and writes it |
//! | `measured.NAME` | read only: the drive's code computes it |
//!
//! The first entry with a path of `parameters` or `values` declares the field. Further entries of
//! the same path are other addresses of it and leave default, range and unit empty.

pub mod actuator;
mod eds;
mod markdown;
mod parse;
mod row;
mod storage;
mod table;
mod value;

pub use eds::{Device, eds};
pub use markdown::markdown;
pub use parse::{ParseError, parse};
pub use row::{Access, DataType, Default, Flag, Row};
pub use storage::{Group, storage};
pub use table::table;
pub use value::{Relation, StorageLocation, ValuePath};

/// First line of each generated file.
const HEAD: &str =
    "Generated from object-dictionary.csv by `cargo run -p canopen-generator`; do not edit.";

/// Entries of one index, sorted by sub-index.
fn objects(rows: &[Row]) -> impl Iterator<Item = &[Row]> {
    rows.chunk_by(|a, b| a.index == b.index)
}

/// The entries that declare a stored field, in the order of the file.
fn declarations(rows: &[Row]) -> impl Iterator<Item = (&Row, &ValuePath)> {
    rows.iter().enumerate().filter_map(|(at, row)| {
        let path = row
            .value
            .as_ref()
            .filter(|path| path.location.is_stored())?;
        let is_alias = rows[..at]
            .iter()
            .any(|other| other.value.as_ref() == Some(path));
        (!is_alias).then_some((row, path))
    })
}

/// Address and names of an entry.
fn title(row: &Row) -> String {
    match row.sub {
        Some(sub) => format!("{:04X}h:{sub:02X} {}: {}", row.index, row.object, row.entry),
        None => format!("{:04X}h {}", row.index, row.object),
    }
}

/// `over_current_ma` as `OverCurrentMa`.
fn camel_case(name: &str) -> String {
    let words = name.split('_').map(|word| {
        let (first, rest) = word.split_at(1.min(word.len()));
        first.to_uppercase() + rest
    });
    words.collect()
}

/// Wraps a text into lines of a documentation comment.
fn doc_comment(indent: &str, text: &str) -> String {
    let mut lines = vec![format!("{indent}///")];
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.len() + 1 + word.len() <= 100 => *line += &format!(" {word}"),
            _ => lines.push(format!("{indent}/// {word}")),
        }
    }
    lines.join("\n") + "\n"
}
