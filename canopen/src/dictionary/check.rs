//! Consistency checks of a dictionary, evaluated at compile time.

use super::{Access, Address, DataType, Dictionary, Entry, Mapping};

/// Inconsistency in the tables of a dictionary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DictionaryError {
    /// The entry does not follow its predecessor in ascending order of addresses.
    Order(Address),
    /// The entry is mappable but has no fixed size or no access in that direction, or it adds the
    /// node-ID to a type other than UNSIGNED32.
    Mapping(Address),
    /// The entry is a sub-index of a communication object that is a VAR.
    SubIndex(Address),
    /// The entry has limits but is not a number of at most 32 bits, or the lower limit exceeds the
    /// upper one.
    Limits(Address),
    /// A writable string is longer than the SDO server's buffer of 64 bytes.
    TooLong(Address),
    /// The entry does not exist or is not a constant VISIBLE_STRING.
    Text(Address),
    /// An entry does not exist, or the two are not of the same numeric data type of at most 32
    /// bits.
    Relation(Address),
}

pub(super) const fn check(dictionary: &Dictionary) -> Result<(), DictionaryError> {
    let mut rest = dictionary.entries;
    let mut last = None;
    while let [entry, after @ ..] = rest {
        if let Some(last) = last
            && last >= entry.address().key()
        {
            return Err(DictionaryError::Order(entry.address()));
        }
        if let Err(error) = check_entry(entry) {
            return Err(error);
        }
        last = Some(entry.address().key());
        rest = after;
    }
    let mut texts = dictionary.texts;
    while let [text, after @ ..] = texts {
        match find(dictionary, text.address) {
            Some((DataType::VisibleString, Access::Const)) => texts = after,
            _ => return Err(DictionaryError::Text(text.address)),
        }
    }
    check_relations(dictionary)
}

const fn check_entry(entry: &Entry) -> Result<(), DictionaryError> {
    let address = entry.address();
    let size = entry.data_type().size();
    let is_node_id_addable = !entry.has_node_id() || matches!(entry.data_type(), DataType::U32);
    if !is_mapping_possible(entry) || !is_node_id_addable {
        return Err(DictionaryError::Mapping(address));
    }
    if address.sub != 0 && is_variable(address.index) {
        return Err(DictionaryError::SubIndex(address));
    }
    if let Some((low, high)) = entry.ordered_limits() {
        match size {
            Some(1..=4) if low <= high => {}
            _ => return Err(DictionaryError::Limits(address)),
        }
    }
    let text = matches!(
        entry.data_type(),
        DataType::VisibleString | DataType::OctetString
    );
    if text && entry.is_writable() && entry.default_value(0) as usize > crate::sdo::BUFFER {
        return Err(DictionaryError::TooLong(address));
    }
    Ok(())
}

/// Whether a PDO can carry the value: RPDOs write it, TPDOs read it, and its size is fixed.
const fn is_mapping_possible(entry: &Entry) -> bool {
    let is_accessible = match entry.mapping() {
        Mapping::None => return true,
        Mapping::Receive => entry.is_writable(),
        Mapping::Transmit => entry.is_readable(),
        Mapping::Both => entry.is_writable() && entry.is_readable(),
    };
    is_accessible && entry.data_type().size().is_some()
}

/// Communication objects of type VAR: the server evaluates their index only.
const fn is_variable(index: u16) -> bool {
    matches!(
        index,
        0x1001 | 0x1005..=0x1007 | 0x1012 | 0x1014 | 0x1015 | 0x1017 | 0x1019 | 0x1F80
    )
}

const fn check_relations(dictionary: &Dictionary) -> Result<(), DictionaryError> {
    let mut relations = dictionary.relations;
    while let [relation, after @ ..] = relations {
        let lower = find(dictionary, relation.lower);
        let upper = find(dictionary, relation.upper);
        match (lower, upper) {
            (Some((a, _)), Some((b, _)))
                if a as u8 == b as u8 && matches!(a.size(), Some(1..=4)) => {}
            _ => return Err(DictionaryError::Relation(relation.lower)),
        }
        relations = after;
    }
    Ok(())
}

const fn find(dictionary: &Dictionary, address: Address) -> Option<(DataType, Access)> {
    let mut rest = dictionary.entries;
    while let [entry, after @ ..] = rest {
        if entry.address().key() == address.key() {
            return Some((entry.data_type(), entry.access()));
        }
        rest = after;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dictionary::{Limits, Relation, Text};

    const fn number(index: u16, sub: u8) -> Entry {
        Entry::new(index, sub, DataType::U16, Access::ReadWrite)
    }

    #[test]
    fn each_error_names_the_address_of_its_entry() {
        use DictionaryError::{Limits as BadLimits, Mapping as BadMapping};
        use DictionaryError::{Order, SubIndex, TooLong};
        const UNSORTED: &[Entry] = &[number(0x2000, 1), number(0x2000, 1)];
        const CROSSED: &[Entry] = &[number(0x2000, 0).limits(&Limits::unsigned(5, 4))];
        const READ_BY_PDO: &[Entry] =
            &[Entry::new(0x2000, 0, DataType::U8, Access::Read).mappable(Mapping::Both)];
        const LONG: &[Entry] =
            &[Entry::new(0x2000, 0, DataType::VisibleString, Access::ReadWrite).value(65)];
        const NO_ARRAY: &[Entry] = &[number(0x1017, 1)];
        let at = Address::new(0x2000, 0);
        for (made, error) in [
            (
                Dictionary::try_new(UNSORTED, &[], &[]),
                Order(Address::new(0x2000, 1)),
            ),
            (Dictionary::try_new(CROSSED, &[], &[]), BadLimits(at)),
            (Dictionary::try_new(READ_BY_PDO, &[], &[]), BadMapping(at)),
            (Dictionary::try_new(LONG, &[], &[]), TooLong(at)),
            (
                Dictionary::try_new(NO_ARRAY, &[], &[]),
                SubIndex(Address::new(0x1017, 1)),
            ),
        ] {
            assert_eq!(made.err(), Some(error));
        }
    }

    #[test]
    fn texts_and_relations_require_entries_of_matching_type() {
        const ENTRIES: &[Entry] = &[
            number(0x2000, 0),
            Entry::new(0x2001, 0, DataType::I32, Access::ReadWrite),
        ];
        let (a, b) = (Address::new(0x2000, 0), Address::new(0x2001, 0));
        const TEXT: &[Text] = &[Text {
            address: Address::new(0x2000, 0),
            text: "",
        }];
        const RELATION: &[Relation] = &[Relation {
            lower: Address::new(0x2001, 0),
            upper: Address::new(0x2000, 0),
        }];
        assert_eq!(
            Dictionary::try_new(ENTRIES, TEXT, &[]).err(),
            Some(DictionaryError::Text(a))
        );
        assert_eq!(
            Dictionary::try_new(ENTRIES, &[], RELATION).err(),
            Some(DictionaryError::Relation(b))
        );
    }
}
