//! Parameters of the board and values of objects: their storage, ranges and relations.
//!
//! [`generated`](self) structs and enums come from `object-dictionary.csv`, see
//! [`crate::dictionary`]. A parameter has one field, in one group of [`BoardParameters`] or
//! [`ObjectValues`]; the enums [`Parameter`] and [`ObjectValue`] name the fields for a bus and a
//! flash memory, as 32-bit words.

/// Implements an enum of the fields of a struct of groups, and access to the fields by it.
macro_rules! entries {
    (
        $(#[doc = $doc:literal])+
        $Entry:ident of $Values:ident {
            $($Variant:ident: $group:ident.$field:ident as $ty:ident $(in $range:expr)?,)+
        }
    ) => {
        $(#[doc = $doc])+
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u8)]
        pub enum $Entry {
            $(
                #[doc = concat!("`", stringify!($group), ".", stringify!($field), "`.")]
                $Variant,
            )+
        }

        impl $Entry {
            /// All of them, in the order of their storage.
            pub const ALL: &'static [Self] = &[$(Self::$Variant),+];

            /// Name and type of each field, in the same order.
            pub const FIELDS: &'static [(&'static str, &'static str)] =
                &[$((stringify!($field), stringify!($ty))),+];
        }

        impl $Values {
            /// The value of a field as a word: the bits of a REAL32, or an integer extended to 32
            /// bits in two's complement.
            pub fn word(&self, entry: $Entry) -> u32 {
                match entry {
                    $($Entry::$Variant => $crate::parameters::Word::word(self.$group.$field),)+
                }
            }

            /// Sets a field to a value of [`Self::word`]; neither range nor relations are
            /// checked.
            pub fn set_word(&mut self, entry: $Entry, word: u32) {
                match entry {
                    $($Entry::$Variant => {
                        self.$group.$field = $crate::parameters::Word::of_word(word);
                    })+
                }
            }

            /// Whether a field is in its range.
            pub(crate) fn is_in_range(&self, entry: $Entry) -> bool {
                match entry {
                    $($Entry::$Variant => true $(&& ($range).contains(&self.$group.$field))?,)+
                }
            }

            /// Checks the range of every field, then the relations between them.
            ///
            /// # Errors
            /// The first field that is out of its range, or breaks a relation.
            pub fn check(&self) -> Result<(), $Entry> {
                let mut fields = $Entry::ALL.iter().copied();
                match fields.find(|field| !self.is_in_range(*field)).or(self.broken_relation()) {
                    Some(field) => Err(field),
                    None => Ok(()),
                }
            }
        }

        impl Default for $Values {
            fn default() -> Self {
                Self::DEFAULT
            }
        }
    };
}

mod generated {
    include!(concat!(env!("OUT_DIR"), "/parameters.rs"));
}
#[cfg(test)]
pub(crate) mod tests;

use model_core::control::{cascade::Coefficients, parameters::ControlParameters};
use model_core::parameter::Parameters;

use crate::faults::{FaultSet, HOLDABLE};

pub use generated::*;

/// Control parameters, by row of the table of [`ControlParameters`].
pub const CONTROL: usize = ControlParameters::TABLE.len();

/// The coefficients of the default control parameters, computed when the program is built: the
/// board needs no 64-bit floating point for them.
const CONTROL_DEFAULT: Coefficients = match Coefficients::try_new(&ControlParameters::DEFAULT) {
    Ok(coefficients) => coefficients,
    Err(_) => panic!("a default is out of its range"),
};

/// A number as a 32-bit word.
trait Word: Copy {
    /// The word of this number.
    fn word(self) -> u32;
    /// The number of this word.
    fn of_word(word: u32) -> Self;
}

macro_rules! integer_words {
    ($($Integer:ident)+) => {
        $(impl Word for $Integer {
            fn word(self) -> u32 {
                self as u32
            }

            fn of_word(word: u32) -> Self {
                word as Self
            }
        })+
    };
}

integer_words!(u8 i8 u16 i16 u32 i32);

impl Word for f32 {
    fn word(self) -> u32 {
        self.to_bits()
    }

    fn of_word(word: u32) -> Self {
        Self::from_bits(word)
    }
}

impl BoardParameters {
    /// The faults after which the motor brakes.
    pub fn braking_faults(&self) -> FaultSet {
        FaultSet::of_bits(self.stop.brake_faults as u32)
    }

    /// The faults after which the shaft is held: those of `hold_faults` after which the motor may
    /// brake, and whose condition leaves encoder, current measurement and motor as they are.
    pub fn holding_faults(&self) -> FaultSet {
        let faults = FaultSet::of_bits(self.stop.hold_faults as u32);
        faults.and(HOLDABLE).and(self.braking_faults())
    }

    /// Writes all parameters as words: the control parameters, then [`Parameter::ALL`].
    ///
    /// A default of double precision is stored in single precision and restored unchanged.
    pub fn write_words<'a>(&self, words: &mut impl Iterator<Item = &'a mut u32>) {
        for row in 0..CONTROL {
            let value = self.control.get(row).unwrap_or(0.0);
            put(words, value.to_bits());
        }
        for parameter in Parameter::ALL {
            put(words, self.word(*parameter));
        }
    }

    /// Reads the words of [`Self::write_words`]; `None` if a parameter is out of its range or
    /// breaks a relation.
    pub fn read_words(words: &mut impl Iterator<Item = u32>) -> Option<Self> {
        let mut parameters = Self::DEFAULT;
        for row in 0..CONTROL {
            let value = f32::from_bits(words.next()?);
            parameters.control.set(row, value).then_some(())?;
        }
        for parameter in Parameter::ALL {
            parameters.set_word(*parameter, words.next()?);
        }
        parameters.check().is_ok().then_some(parameters)
    }

    /// Whether both have the same parameters, except for those of the control step.
    pub fn differs_in_control_only(&self, other: &Self) -> bool {
        let control = self.control;
        *self == Self { control, ..*other }
    }
}

impl ObjectValues {
    /// Writes all values as words, in the order of [`ObjectValue::ALL`].
    pub fn write_words<'a>(&self, words: &mut impl Iterator<Item = &'a mut u32>) {
        for value in ObjectValue::ALL {
            put(words, self.word(*value));
        }
    }

    /// Reads the words of [`Self::write_words`]; `None` if a value is out of its range or breaks a
    /// relation.
    pub fn read_words(words: &mut impl Iterator<Item = u32>) -> Option<Self> {
        let mut values = Self::DEFAULT;
        for value in ObjectValue::ALL {
            values.set_word(*value, words.next()?);
        }
        values.check().is_ok().then_some(values)
    }
}

fn put<'a>(words: &mut impl Iterator<Item = &'a mut u32>, value: u32) {
    if let Some(word) = words.next() {
        *word = value;
    }
}
