//! The object dictionary: constant descriptions of all objects.

mod check;
mod data_type;
mod entry;
mod kind;
mod packed;

pub use check::DictionaryError;
pub use data_type::DataType;
pub use entry::{Entry, Limits};
pub use kind::{Access, Mapping};
pub use packed::{Numbers, Packed, Row};

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

/// Two objects of which the first must not exceed the second, for example 607Dh:1 and 607Dh:2. A
/// write to either object that violates the relation is refused with
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
    rows: &'static [Row],
    values: &'static [u32],
    limits: &'static [Limits],
    texts: &'static [Text],
    relations: &'static [Relation],
}

/// Packs and checks constant slices of entries, texts and relations. Evaluates to a
/// `Result<Dictionary, DictionaryError>`; in a `const`, an error ends the compilation.
///
/// ```
/// use canopen::Dictionary;
/// use canopen::dictionary::{Access, Address, DataType, Entry};
/// const ENTRIES: &[Entry] = &[Entry::new(0x1000, 0, DataType::U32, Access::Const).value(0x192)];
/// const DICTIONARY: Dictionary = match canopen::dictionary!(ENTRIES, &[], &[]) {
///     Ok(dictionary) => dictionary,
///     Err(_) => panic!("invalid object dictionary"),
/// };
/// let row = DICTIONARY.find(Address::new(0x1000, 0)).unwrap();
/// assert_eq!(DICTIONARY.value(row, 5), 0x192);
/// ```
#[macro_export]
macro_rules! dictionary {
    ($entries:expr, $texts:expr, $relations:expr) => {{
        // Names of items are seen in the arguments: these must not be anybody's.
        const DICTIONARY_NUMBERS: $crate::dictionary::Numbers =
            $crate::dictionary::Numbers::of($entries);
        const DICTIONARY_PACKED: &$crate::dictionary::Packed<
            { DICTIONARY_NUMBERS.entries() },
            { DICTIONARY_NUMBERS.values() },
            { DICTIONARY_NUMBERS.limits() },
        > = &$crate::dictionary::Packed::new($entries, &DICTIONARY_NUMBERS);
        $crate::Dictionary::new(DICTIONARY_PACKED, $texts, $relations)
    }};
}

impl Dictionary {
    /// Checks the tables; [`dictionary!`](crate::dictionary!) also packs the entries.
    ///
    /// # Errors
    /// The first inconsistency in the tables, with its address.
    pub const fn new<const E: usize, const V: usize, const L: usize>(
        entries: &'static Packed<E, V, L>,
        texts: &'static [Text],
        relations: &'static [Relation],
    ) -> Result<Self, DictionaryError> {
        let dictionary = Self {
            rows: &entries.rows,
            values: &entries.values,
            limits: &entries.limits,
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
    pub const fn rows(&self) -> &'static [Row] {
        self.rows
    }

    /// The value of a constant, or the default of an object, as bits of its data type, for this
    /// node-ID.
    #[must_use]
    pub const fn value(&self, row: &Row, node_id: u8) -> u32 {
        let at = row.value as usize;
        let value = if at < self.values.len() {
            self.values[at]
        } else {
            0
        };
        if row.has_node_id() {
            value.wrapping_add(node_id as u32)
        } else {
            value
        }
    }

    /// Limits of an object, if any, in the order of [`DataType::ordered`].
    pub(crate) const fn limits(&self, row: &Row) -> Option<(i32, i32)> {
        let at = row.limits as usize;
        if at >= self.limits.len() {
            return None;
        }
        let Limits { minimum, maximum } = self.limits[at];
        let data_type = row.data_type();
        Some((data_type.ordered(minimum), data_type.ordered(maximum)))
    }

    /// The entry at an address.
    ///
    /// # Errors
    /// [`Abort::NoObject`] if the index does not exist, [`Abort::NoSubIndex`] if only the sub-index
    /// does not exist.
    pub fn find(&self, address: Address) -> Result<&'static Row, Abort> {
        // If only the sub-index is missing, the preceding entry belongs to the same index: every
        // object has sub-index 0.
        let found = self.search(address);
        let nearest = found.unwrap_or_else(|after| after.wrapping_sub(1));
        match (found, self.rows.get(nearest)) {
            (Ok(_), Some(row)) => Ok(row),
            (Err(_), Some(row)) if row.address().index == address.index => Err(Abort::NoSubIndex),
            _ => Err(Abort::NoObject),
        }
    }

    /// Position of an entry in [`Dictionary::rows`].
    #[must_use]
    pub fn position(&self, address: Address) -> Option<usize> {
        self.search(address).ok()
    }

    /// Position of an entry, or the position at which it would be inserted.
    fn search(&self, address: Address) -> Result<usize, usize> {
        let key = |row: &Row| row.address().key();
        self.rows.binary_search_by_key(&address.key(), key)
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
