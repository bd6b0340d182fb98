//! One source for an object dictionary: from a CSV file come the const table of the crate `canopen`, the
//! electronic data sheet (CiA 306) and the documentation.
//!
//! The columns are `index,sub,object,entry,type,access,pdo,default,min,max,unit,flags,not_above`. An empty `sub` makes
//! the object one variable. `type` is one of u8 to u64, i8 to i64, f32, str, dom; `access` one of const, ro, wo, rw, rww
//! (may be mapped in RPDOs); `pdo` is `x` where the object may be mapped. `flags` is `fixed` for what is read from the
//! table, or `locked` for what is not to be written while the drive is enabled. `not_above` names the object that this
//! one must not be above. No field has a comma or a quote in it.

pub mod actuator;
mod eds;
mod markdown;
mod parse;
mod row;
mod table;

pub use eds::{Device, eds};
pub use markdown::markdown;
pub use parse::{ParseError, parse};
pub use row::{Access, Default, Flag, Kind, Row};
pub use table::table;

/// What is written at the head of each file that is made.
const HEAD: &str =
    "Made from object-dictionary.csv by `cargo run -p canopen-generator`; not to be edited.";

/// Rows of one index, in the order of their sub-indices.
fn objects(rows: &[Row]) -> impl Iterator<Item = &[Row]> {
    rows.chunk_by(|a, b| a.index == b.index)
}
