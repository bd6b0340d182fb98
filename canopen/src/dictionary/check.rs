//! What must hold in a dictionary, checked while the compiler runs.

use super::{Access, Address, DataType, Dictionary, Mapping};

/// What is wrong with the tables of a dictionary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DictionaryError {
    /// The entry stands before one of a lower or equal address.
    Order(Address),
    /// The entry is mappable, but has no fixed size, or cannot be accessed in that direction.
    Mapping(Address),
    /// The entry has limits, but is no number of at most 32 bits, or the limits exclude each other.
    Limits(Address),
    /// A string that can be written is longer than the 64 bytes of the SDO server's buffer.
    TooLong(Address),
    /// There is no such entry, or it is no constant VISIBLE_STRING.
    Text(Address),
    /// There is no such entry, or the two are not of one numeric data type.
    Relation(Address),
}

pub(super) const fn check(dictionary: &Dictionary) -> Result<(), DictionaryError> {
    let mut at = 0;
    let mut last = None;
    while at < dictionary.entries.len() {
        if let Err(error) = check_entry(dictionary, at, last) {
            return Err(error);
        }
        last = Some(dictionary.entries[at].address().key());
        at += 1;
    }
    let mut at = 0;
    while at < dictionary.texts.len() {
        let address = dictionary.texts[at].address;
        match entry_type(dictionary, address) {
            Some((DataType::Text, Access::Const)) => at += 1,
            _ => return Err(DictionaryError::Text(address)),
        }
    }
    check_relations(dictionary)
}

const fn check_entry(
    dictionary: &Dictionary,
    at: usize,
    last: Option<u32>,
) -> Result<(), DictionaryError> {
    let entry = &dictionary.entries[at];
    let address = entry.address();
    if let Some(last) = last
        && last >= address.key()
    {
        return Err(DictionaryError::Order(address));
    }
    let size = entry.data_type().size();
    let fits = match entry.mapping() {
        Mapping::None => true,
        Mapping::Receive => size.is_some() && entry.writable(),
        Mapping::Transmit => size.is_some() && entry.readable(),
        Mapping::Both => size.is_some() && entry.readable() && entry.writable(),
    };
    if !fits {
        return Err(DictionaryError::Mapping(address));
    }
    if let Some((low, high)) = entry.limit_pair() {
        match size {
            Some(1..=4) if low <= high => {}
            _ => return Err(DictionaryError::Limits(address)),
        }
    }
    let text = matches!(entry.data_type(), DataType::Text | DataType::Octets);
    if text && entry.writable() && entry.value_for(0) as usize > crate::sdo::BUFFER {
        return Err(DictionaryError::TooLong(address));
    }
    Ok(())
}

const fn check_relations(dictionary: &Dictionary) -> Result<(), DictionaryError> {
    let mut at = 0;
    while at < dictionary.relations.len() {
        let relation = &dictionary.relations[at];
        let lower = entry_type(dictionary, relation.lower);
        let upper = entry_type(dictionary, relation.upper);
        match (lower, upper) {
            (Some((a, _)), Some((b, _)))
                if a as u8 == b as u8 && a.size().is_some() && !matches!(a, DataType::F64) => {}
            _ => return Err(DictionaryError::Relation(relation.lower)),
        }
        at += 1;
    }
    Ok(())
}

const fn entry_type(dictionary: &Dictionary, address: Address) -> Option<(DataType, Access)> {
    let mut at = 0;
    while at < dictionary.entries.len() {
        let entry = &dictionary.entries[at];
        if entry.address().key() == address.key() {
            return Some((entry.data_type(), entry.access()));
        }
        at += 1;
    }
    None
}
