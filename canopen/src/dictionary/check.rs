//! What must hold in a dictionary, checked while the compiler runs.

use super::{Access, Address, DataType, Dictionary, Mapping, Row};

/// What is wrong with the tables of a dictionary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DictionaryError {
    /// The entry stands before one of a lower or equal address.
    Order(Address),
    /// The entry is mappable, but has no fixed size, or cannot be accessed in that direction; or it adds the node-ID to what is no
    /// UNSIGNED32.
    Mapping(Address),
    /// The entry is a sub-index of a communication object that is one variable.
    SubIndex(Address),
    /// The entry has limits, but is no number of at most 32 bits, or the limits exclude each other.
    Limits(Address),
    /// A string that can be written is longer than the 64 bytes of the SDO server's buffer.
    TooLong(Address),
    /// There is no such entry, or it is no constant VISIBLE_STRING.
    Text(Address),
    /// There is no such entry, or the two are not of one data type for numbers of at most 32 bits.
    Relation(Address),
}

pub(super) const fn check(dictionary: &Dictionary) -> Result<(), DictionaryError> {
    let mut rest = dictionary.rows;
    let mut last = None;
    while let [row, after @ ..] = rest {
        if let Some(last) = last
            && last >= row.address().key()
        {
            return Err(DictionaryError::Order(row.address()));
        }
        if let Err(error) = check_row(dictionary, row) {
            return Err(error);
        }
        last = Some(row.address().key());
        rest = after;
    }
    let mut texts = dictionary.texts;
    while let [text, after @ ..] = texts {
        match find(dictionary, text.address) {
            Some((DataType::Text, Access::Const)) => texts = after,
            _ => return Err(DictionaryError::Text(text.address)),
        }
    }
    check_relations(dictionary)
}

const fn check_row(dictionary: &Dictionary, row: &Row) -> Result<(), DictionaryError> {
    let address = row.address();
    let size = row.data_type().size();
    // Access in the right direction is a matter of how the entry is made.
    let fits = matches!(row.mapping(), Mapping::None) || size.is_some();
    if !fits || row.is_impossible() {
        return Err(DictionaryError::Mapping(address));
    }
    if address.sub != 0 && is_variable(address.index) {
        return Err(DictionaryError::SubIndex(address));
    }
    if let Some((low, high)) = dictionary.limits(row) {
        match size {
            Some(1..=4) if low <= high => {}
            _ => return Err(DictionaryError::Limits(address)),
        }
    }
    let text = matches!(row.data_type(), DataType::Text | DataType::Octets);
    if text && row.writable() && dictionary.value(row, 0) as usize > crate::sdo::BUFFER {
        return Err(DictionaryError::TooLong(address));
    }
    Ok(())
}

/// Communication objects that are one variable each: the server looks at their index alone.
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
    let mut rest = dictionary.rows;
    while let [row, after @ ..] = rest {
        if row.address().key() == address.key() {
            return Some((row.data_type(), row.access()));
        }
        rest = after;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dictionary::{Entry, Limits, Relation, Text};

    const fn number(index: u16, sub: u8) -> Entry {
        Entry::new(index, sub, DataType::U16, Access::ReadWrite)
    }

    #[test]
    fn what_is_wrong_is_named_with_its_address() {
        use DictionaryError::{Limits as BadLimits, Mapping as BadMapping};
        use DictionaryError::{Order, SubIndex, TooLong};
        const UNSORTED: &[Entry] = &[number(0x2000, 1), number(0x2000, 1)];
        const CROSSED: &[Entry] = &[number(0x2000, 0).limits(&Limits::unsigned(5, 4))];
        const READ_BY_PDO: &[Entry] =
            &[Entry::new(0x2000, 0, DataType::U8, Access::Read).mappable(Mapping::Both)];
        const LONG: &[Entry] =
            &[Entry::new(0x2000, 0, DataType::Text, Access::ReadWrite).value(65)];
        const NO_ARRAY: &[Entry] = &[number(0x1017, 1)];
        let at = Address::new(0x2000, 0);
        for (made, error) in [
            (
                crate::dictionary!(UNSORTED, &[], &[]),
                Order(Address::new(0x2000, 1)),
            ),
            (crate::dictionary!(CROSSED, &[], &[]), BadLimits(at)),
            (crate::dictionary!(READ_BY_PDO, &[], &[]), BadMapping(at)),
            (crate::dictionary!(LONG, &[], &[]), TooLong(at)),
            (
                crate::dictionary!(NO_ARRAY, &[], &[]),
                SubIndex(Address::new(0x1017, 1)),
            ),
        ] {
            assert_eq!(made.err(), Some(error));
        }
    }

    #[test]
    fn texts_and_relations_need_entries_of_their_kind() {
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
            crate::dictionary!(ENTRIES, TEXT, &[]).err(),
            Some(DictionaryError::Text(a))
        );
        assert_eq!(
            crate::dictionary!(ENTRIES, &[], RELATION).err(),
            Some(DictionaryError::Relation(b))
        );
    }
}
