//! The object dictionary, and where the value of each object lives.
//!
//! `object-dictionary.csv` is the only declaration of objects and parameters. From each of its
//! lines the build script writes the entry of the const table with its `Location`, and the field
//! that stores the value with default, range and relation (module [`crate::parameters`]);
//! `canopen-generator` writes the electronic data sheet (`docs/smart-actuator.eds`) and the
//! documentation (`docs/object-dictionary.md`). These documents are committed, and a test compares
//! them with the source. Ranges and defaults of the control parameters come from `model-core`, to
//! which the lines refer by name.
//!
//! The declaration is a table and not a Rust macro because clients in other languages read it too,
//! a line shows all facts of an object side by side, a change is one line of a diff, and the
//! generated code is plain Rust that an editor can follow.
//!
//! Each entry has the number of its line: `location` finds the location of an entry by it, and the
//! drive matches on that.

#[allow(
    clippy::large_const_arrays,
    reason = "read when the program is built alone, into the statics below"
)]
mod table {
    include!(concat!(env!("OUT_DIR"), "/table.rs"));
}
#[cfg(test)]
mod tests;

use canopen::Dictionary;
use canopen::dictionary::Entry;

use crate::parameters::{ObjectValue, Parameter};

pub(crate) use table::{COMMUNICATION, DriveCommand, Measured};

/// All objects of the actuator; the compiler checks their consistency.
pub const DICTIONARY: Dictionary =
    match Dictionary::try_new(&ENTRIES, table::TEXTS, table::RELATIONS) {
        Ok(dictionary) => dictionary,
        Err(_) => panic!("object-dictionary.csv is inconsistent"),
    };

/// Where the value of an object lives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Location {
    /// In the server of the crate `canopen`, in the dictionary, or it is a DOMAIN.
    Server,
    /// In the server, which has it stored: its position among the communication parameters.
    Communication(u8),
    /// A control parameter, by its row.
    Control(usize),
    /// An integer parameter of the board.
    Parameter(Parameter),
    /// A value that the drive stores.
    Value(ObjectValue),
    /// A value that code of the drive reads and writes.
    Command(DriveCommand),
    /// A value that is computed when it is read.
    Measured(Measured),
}

/// Number of entries.
const COUNT: usize = table::OBJECTS.len();

/// The entries alone.
const ENTRIES: [Entry; COUNT] = {
    let mut entries = [table::OBJECTS[0].0; COUNT];
    let mut at = 0;
    while at < COUNT {
        entries[at] = table::OBJECTS[at].0.numbered(at as u16);
        at += 1;
    }
    entries
};

/// The location of each entry.
pub(crate) static LOCATIONS: [Location; COUNT] = {
    let mut locations = [Location::Server; COUNT];
    let mut at = 0;
    while at < COUNT {
        locations[at] = table::OBJECTS[at].1;
        at += 1;
    }
    locations
};

/// Where the value of an object lives.
pub(crate) fn location(entry: &Entry) -> Location {
    let location = LOCATIONS.get(usize::from(entry.number()));
    location.copied().unwrap_or(Location::Server)
}

/// The stored communication parameters, in the order of their positions.
pub(crate) static COMMUNICATION_ENTRIES: [Entry; COMMUNICATION] = {
    let mut found = [table::OBJECTS[0].0; COMMUNICATION];
    let mut at = 0;
    while at < COUNT {
        if let Location::Communication(position) = table::OBJECTS[at].1 {
            found[position as usize] = table::OBJECTS[at].0;
        }
        at += 1;
    }
    found
};
