//! The object dictionary: made from `object-dictionary.csv`, as its data sheet `docs/smart-actuator.eds` and its
//! documentation `docs/object-dictionary.md` are.

mod table;
#[cfg(test)]
mod tests;

use canopen::Dictionary;

/// All objects of the actuator. The compiler has checked that they go together.
pub const DICTIONARY: Dictionary =
    match Dictionary::try_new(table::ENTRIES, table::TEXTS, table::RELATIONS) {
        Ok(dictionary) => dictionary,
        Err(_) => panic!("object-dictionary.csv is not sound"),
    };
