//! The object dictionary: const data that says which objects there are.

mod check;
mod data_type;
mod entry;

pub use check::DictionaryError;
pub use data_type::DataType;
pub use entry::{Access, Entry, Limits, Mapping};

use crate::Abort;

/// Index and sub-index of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Address {
    /// Index.
    pub index: u16,
    /// Sub-index; 0 for an object that is one variable.
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
    /// Whose text.
    pub address: Address,
    /// The text, in ASCII.
    pub text: &'static str,
}

/// Two objects of which the first must never be above the second, as 607Dh:1 and 607Dh:2.
///
/// A write that would break it is refused with
/// [`Abort::MaximumBelowMinimum`], whichever of the two it goes to.
#[derive(Clone, Copy, Debug)]
pub struct Relation {
    /// The lower of the two.
    pub lower: Address,
    /// The upper of the two, of the same data type.
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
    /// Checks and takes the tables; meant for a `const`, where an error stops the compiler.
    ///
    /// # Errors
    ///
    /// What is wrong in the tables, with the address where.
    ///
    /// ```
    /// use canopen::dictionary::{Access, Address, DataType, Dictionary, Entry};
    /// const ENTRIES: &[Entry] = &[Entry::new(0x1000, 0, DataType::U32, Access::Const).value(0x192)];
    /// const DICTIONARY: Dictionary = match Dictionary::new(ENTRIES, &[], &[]) {
    ///     Ok(dictionary) => dictionary,
    ///     Err(_) => panic!("the dictionary is not sound"),
    /// };
    /// assert!(DICTIONARY.find(Address::new(0x1000, 0)).is_ok());
    /// ```
    pub const fn new(
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

    /// The entry at an address.
    ///
    /// # Errors
    ///
    /// [`Abort::NoObject`] where the index, [`Abort::NoSubIndex`] where only the sub-index is missing.
    pub fn find(&self, address: Address) -> Result<&'static Entry, Abort> {
        let at = self
            .entries
            .partition_point(|entry| entry.address() < address);
        match self.entries.get(at) {
            Some(entry) if entry.address() == address => Ok(entry),
            Some(entry) if entry.index == address.index => Err(Abort::NoSubIndex),
            _ => match at
                .checked_sub(1)
                .and_then(|before| self.entries.get(before))
            {
                Some(entry) if entry.index == address.index => Err(Abort::NoSubIndex),
                _ => Err(Abort::NoObject),
            },
        }
    }

    /// Where among [`Dictionary::entries`] the entry at an address is.
    #[must_use]
    pub fn position(&self, address: Address) -> Option<usize> {
        let position = (self.entries).binary_search_by_key(&address, Entry::address);
        position.ok()
    }

    /// The text of a constant string; empty where there is none.
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
