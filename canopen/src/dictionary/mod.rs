//! The object dictionary: constant descriptions of all objects.

mod check;
mod data_type;
mod entry;

pub use check::DictionaryError;
pub use data_type::DataType;
pub use entry::{Access, Entry, Limits, Mapping};

use core::ops::Range;

use crate::Abort;

/// Index and sub-index of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Address {
    /// Index.
    pub index: u16,
    /// Sub-index; 0 for a VAR.
    pub sub: u8,
}

impl Address {
    /// The address of `index`:`sub`.
    #[must_use]
    pub const fn new(index: u16, sub: u8) -> Self {
        Self { index, sub }
    }

    /// As the upper 24 bits of a PDO mapping entry.
    const fn key(self) -> u32 {
        (self.index as u32) << 8 | self.sub as u32
    }
}

/// The text of a constant VISIBLE_STRING.
#[derive(Clone, Copy, Debug)]
pub struct Text {
    /// Address of the string.
    pub address: Address,
    /// Its value, in ASCII.
    pub text: &'static str,
}

/// Two objects of which the first must not exceed the second, for example 607Dh:1 and 607Dh:2.
///
/// A write to either object that violates the relation is refused with
/// [`Abort::MaximumBelowMinimum`].
#[derive(Clone, Copy, Debug)]
pub struct Relation {
    /// The smaller object.
    pub lower: Address,
    /// The larger object, of the same data type.
    pub upper: Address,
}

/// All objects of a device, sorted by address.
#[derive(Clone, Copy, Debug)]
pub struct Dictionary {
    entries: &'static [Entry],
    texts: &'static [Text],
    relations: &'static [Relation],
}

impl Dictionary {
    /// Checks the tables; in a `const`, an error ends the compilation.
    ///
    /// ```
    /// use canopen::Dictionary;
    /// use canopen::dictionary::{Access, Address, DataType, Entry};
    /// const ENTRIES: &[Entry] = &[Entry::new(0x1000, 0, DataType::U32, Access::Const).value(0x192)];
    /// const DICTIONARY: Dictionary = match Dictionary::try_new(ENTRIES, &[], &[]) {
    ///     Ok(dictionary) => dictionary,
    ///     Err(_) => panic!("invalid object dictionary"),
    /// };
    /// let entry = DICTIONARY.find(Address::new(0x1000, 0)).unwrap();
    /// assert_eq!(entry.default_value(5), 0x192);
    /// ```
    ///
    /// # Errors
    ///
    /// The first inconsistency in the tables, with its address.
    pub const fn try_new(
        entries: &'static [Entry],
        texts: &'static [Text],
        relations: &'static [Relation],
    ) -> Result<Self, DictionaryError> {
        let dictionary = Self {
            entries,
            texts,
            relations,
        };
        match check::check(&dictionary) {
            Ok(()) => Ok(dictionary),
            Err(error) => Err(error),
        }
    }

    /// All entries, sorted by address.
    #[must_use]
    pub const fn entries(&self) -> &'static [Entry] {
        self.entries
    }

    /// The entries of these indices.
    pub(crate) fn range(&self, indices: Range<u16>) -> &'static [Entry] {
        let before = |index: u16| {
            self.entries
                .partition_point(|entry| entry.address().index < index)
        };
        let range = before(indices.start)..before(indices.end);
        self.entries.get(range).unwrap_or_default()
    }

    /// The entry at an address.
    ///
    /// # Errors
    ///
    /// [`Abort::NoObject`] if the index does not exist, [`Abort::NoSubIndex`] if only the sub-index
    /// does not exist.
    pub fn find(&self, address: Address) -> Result<&'static Entry, Abort> {
        // If only the sub-index is missing, the preceding entry belongs to the same index: every
        // object has sub-index 0.
        let found = self.search(address);
        let nearest = found.unwrap_or_else(|after| after.wrapping_sub(1));
        match (found, self.entries.get(nearest)) {
            (Ok(_), Some(entry)) => Ok(entry),
            (Err(_), Some(entry)) if entry.address().index == address.index => {
                Err(Abort::NoSubIndex)
            }
            _ => Err(Abort::NoObject),
        }
    }

    /// Position of an entry in [`Dictionary::entries`].
    #[must_use]
    pub fn position(&self, address: Address) -> Option<usize> {
        self.search(address).ok()
    }

    /// Position of an entry, or the position at which it would be inserted.
    fn search(&self, address: Address) -> Result<usize, usize> {
        let key = |entry: &Entry| entry.address().key();
        self.entries.binary_search_by_key(&address.key(), key)
    }

    /// The value of a constant string; empty if it has none.
    pub(crate) fn text(&self, address: Address) -> &'static [u8] {
        self.texts
            .iter()
            .find(|text| text.address == address)
            .map_or(&[], |text| text.text.as_bytes())
    }

    pub(crate) fn relations(&self) -> &'static [Relation] {
        self.relations
    }
}
