//! The largest dictionary that there is.

#[path = "../../../../firmware/src/dictionary/table.rs"]
mod table;

use canopen::Dictionary;

pub const DICTIONARY: Dictionary =
    match canopen::dictionary!(table::ENTRIES, table::TEXTS, table::RELATIONS) {
        Ok(dictionary) => dictionary,
        Err(_) => panic!("the dictionary is not sound"),
    };
