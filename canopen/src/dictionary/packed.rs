//! The tables of a dictionary as they lie in the flash: six bytes for each entry, and every number once.

use super::entry::{Entry, Limits};
use super::kind::Kind;
use super::{Access, Address, DataType, Mapping};

/// An entry of a dictionary; its default and its limits are the [`Dictionary`](super::Dictionary)'s to tell.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    index: u16,
    sub: u8,
    kind: Kind,
    /// Where its value stands among the values.
    pub(super) value: u8,
    /// Where its limits stand among the limits; [`NONE`] without any.
    pub(super) limits: u8,
}

/// The place of no limits.
const NONE: u8 = u8::MAX;

impl Row {
    /// Index and sub-index.
    #[must_use]
    pub const fn address(&self) -> Address {
        Address::new(self.index, self.sub)
    }

    /// Data type.
    #[must_use]
    pub const fn data_type(&self) -> DataType {
        self.kind.data_type()
    }

    /// Who may read and write it.
    #[must_use]
    pub const fn access(&self) -> Access {
        self.kind.access()
    }

    /// In which PDOs it may be mapped.
    #[must_use]
    pub const fn mapping(&self) -> Mapping {
        self.kind.mapping()
    }

    /// Whether the node-ID is added to its value.
    #[must_use]
    pub const fn has_node_id(&self) -> bool {
        self.kind.has_node_id()
    }

    pub(super) const fn is_impossible(&self) -> bool {
        self.kind.is_impossible()
    }

    pub(crate) const fn readable(&self) -> bool {
        !matches!(self.access(), Access::Write)
    }

    pub(crate) const fn writable(&self) -> bool {
        matches!(self.access(), Access::Write | Access::ReadWrite)
    }

    pub(crate) const fn is_guarded(&self) -> bool {
        self.kind.is_guarded()
    }
}

/// All different numbers in the entries of a dictionary, in the order in which they first occur.
#[derive(Clone, Copy, Debug)]
pub struct Numbers {
    entries: usize,
    values: [u32; 256],
    value_count: usize,
    limits: [Limits; NONE as usize],
    limit_count: usize,
}

impl Numbers {
    /// Those of these entries.
    ///
    /// # Panics
    ///
    /// That is, the compiler stops: there are more than 256 different values, or 255 different pairs of limits.
    #[must_use]
    pub const fn of(entries: &[Entry]) -> Self {
        let mut numbers = Self {
            entries: entries.len(),
            values: [0; 256],
            value_count: 0,
            limits: [Limits::unsigned(0, 0); NONE as usize],
            limit_count: 0,
        };
        let mut rest = entries;
        while let [entry, after @ ..] = rest {
            if numbers.place_of_value(entry) == numbers.value_count {
                assert!(numbers.value_count < 256, "more than 256 different values");
                numbers.values[numbers.value_count] = entry.value;
                numbers.value_count += 1;
            }
            if let Some(limits) = entry.limits
                && numbers.place_of_limits(limits) == numbers.limit_count
            {
                assert!(
                    numbers.limit_count < NONE as usize,
                    "more than 255 different limits"
                );
                numbers.limits[numbers.limit_count] = *limits;
                numbers.limit_count += 1;
            }
            rest = after;
        }
        numbers
    }

    /// How many entries they are of.
    #[must_use]
    pub const fn entries(&self) -> usize {
        self.entries
    }

    /// How many values there are.
    #[must_use]
    pub const fn values(&self) -> usize {
        self.value_count
    }

    /// How many pairs of limits there are.
    #[must_use]
    pub const fn limits(&self) -> usize {
        self.limit_count
    }

    const fn place_of_value(&self, entry: &Entry) -> usize {
        let mut at = 0;
        while at < self.value_count && self.values[at] != entry.value {
            at += 1;
        }
        at
    }

    const fn place_of_limits(&self, wanted: &Limits) -> usize {
        let mut at = 0;
        while at < self.limit_count {
            let limits = &self.limits[at];
            if limits.minimum == wanted.minimum && limits.maximum == wanted.maximum {
                break;
            }
            at += 1;
        }
        at
    }

    const fn row(&self, entry: &Entry) -> Row {
        Row {
            index: entry.address.index,
            sub: entry.address.sub,
            kind: entry.kind,
            value: self.place_of_value(entry) as u8,
            limits: match entry.limits {
                Some(limits) => self.place_of_limits(limits) as u8,
                None => NONE,
            },
        }
    }
}

/// `E` entries with `V` different values and `L` different pairs of limits.
#[derive(Clone, Copy, Debug)]
pub struct Packed<const E: usize, const V: usize, const L: usize> {
    pub(super) rows: [Row; E],
    pub(super) values: [u32; V],
    pub(super) limits: [Limits; L],
}

impl<const E: usize, const V: usize, const L: usize> Packed<E, V, L> {
    /// Packs entries, the numbers of which these are.
    ///
    /// # Panics
    ///
    /// That is, the compiler stops: the sizes are not those of the entries and of the numbers.
    #[must_use]
    pub const fn new(entries: &[Entry], numbers: &Numbers) -> Self {
        assert!(entries.len() == E && numbers.value_count == V && numbers.limit_count == L);
        let mut packed = Self {
            rows: [numbers.row(&Entry::new(0, 0, DataType::U8, Access::Const)); E],
            values: [0; V],
            limits: [Limits::unsigned(0, 0); L],
        };
        let mut at = 0;
        while at < E {
            packed.rows[at] = numbers.row(&entries[at]);
            at += 1;
        }
        packed.values.copy_from_slice(numbers.values.split_at(V).0);
        packed.limits.copy_from_slice(numbers.limits.split_at(L).0);
        packed
    }
}
