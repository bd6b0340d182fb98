//! Parameters by number, as a bus asks for them and a flash memory keeps them.
//!
//! The numbers start with the rows of
//! [`ControlParameters`](model_core::control::parameters::ControlParameters), in single precision;
//! then follow the groups of integers in the order of the fields of [`BoardParameters`].

use model_core::{control::parameters::ControlParameters, parameter::Parameters};

use super::{
    BoardParameters,
    integers::{Integers, Range, Row},
};

/// Parameters of the control step: the first numbers.
pub const CONTROL: usize = ControlParameters::TABLE.len();

/// The value of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// Of the control step.
    Real(f32),
    /// All others.
    Integer(i32),
}

/// What is known of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Meaning {
    /// Of the control step.
    Real(&'static model_core::parameter::Parameter),
    /// All others.
    Integer(&'static Row),
}

impl Meaning {
    /// Its name.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Real(parameter) => parameter.name,
            Self::Integer(row) => row.name,
        }
    }
}

/// Flattens the groups of integers, in the order of their numbers: what concerns all of them is a
/// loop then, which takes less of the flash than code for each field.
macro_rules! groups {
    ($($field:ident: $Group:ident),+ $(,)?) => {
        /// Parameters beyond those of the control step.
        const INTEGERS: usize = 0 $(+ <super::$Group as Integers>::RANGES.len())+;

        /// Their ranges.
        const RANGES: [Range; INTEGERS] = {
            let mut ranges = [Range { min: 0, max: 0 }; INTEGERS];
            let mut number = 0;
            $(
                let mut row = 0;
                while row < <super::$Group as Integers>::RANGES.len() {
                    ranges[number] = <super::$Group as Integers>::RANGES[row];
                    row += 1;
                    number += 1;
                }
            )+
            ranges
        };

        impl BoardParameters {
            /// All integers.
            #[inline]
            pub(crate) fn integers(&self) -> [i32; INTEGERS] {
                let mut integers = [0; INTEGERS];
                self.give_all(&mut integers);
                integers
            }

            /// Behind a reference the compiler moves them in groups, and not one by one through the stack.
            #[inline(never)]
            fn give_all(&self, integers: &mut [i32; INTEGERS]) {
                let rest = integers.as_mut_slice();
                $(let rest = self.$field.give(rest);)+
                let _ = rest;
            }

            /// Takes all integers, in place: the whole of them is much for a stack.
            #[inline(never)]
            fn take_all(&mut self, integers: &[i32; INTEGERS]) {
                let rest = integers.as_slice();
                $(let rest = self.$field.take(rest);)+
                let _ = rest;
            }

            /// What is known of a parameter; `None` beyond the last one.
            pub fn meaning(number: u8) -> Option<Meaning> {
                let number = usize::from(number);
                if let Some(parameter) = ControlParameters::TABLE.get(number) {
                    return Some(Meaning::Real(parameter));
                }
                [$(<super::$Group as Integers>::TABLE),+]
                    .into_iter()
                    .flatten()
                    .nth(number.checked_sub(CONTROL)?)
                    .map(Meaning::Integer)
            }
        }
    };
}

groups! {
    stop: StopSettings,
    command: CommandSettings,
    servo: ServoSettings,
    bus: BusSettings,
    encoder: EncoderLimits,
    current: CurrentLimits,
    stall: StallLimits,
    following: FollowingLimits,
    supply: SupplyLimits,
    temperature: TemperatureLimits,
    timing: TimingLimits,
}

/// Words of [`BoardParameters::words`].
pub const WORDS: usize = CONTROL + INTEGERS;

impl BoardParameters {
    /// How many parameters there are.
    pub const COUNT: u8 = WORDS as u8;

    /// The number of the parameter of this name.
    ///
    /// ```
    /// use firmware::parameters::{BoardParameters, Value};
    /// let number = BoardParameters::number_of("node_id").unwrap();
    /// assert_eq!(BoardParameters::DEFAULT.get(number), Some(Value::Integer(1)));
    /// assert_eq!(BoardParameters::number_of("position_gain"), Some(0));
    /// ```
    pub fn number_of(name: &str) -> Option<u8> {
        (0..Self::COUNT).find(|&n| Self::meaning(n).is_some_and(|known| known.name() == name))
    }

    /// The value of a parameter; `None` beyond the last one.
    pub fn get(&self, number: u8) -> Option<Value> {
        let number = usize::from(number);
        match self.control.get(number) {
            Some(value) => Some(Value::Real(value)),
            None => {
                let integers = self.integers();
                integers
                    .get(number.checked_sub(CONTROL)?)
                    .map(|&value| Value::Integer(value))
            }
        }
    }

    /// Sets a parameter; `false`, and nothing is changed, where there is no such number, the value
    /// is of the other kind, out of its range, or the control step has no such coefficients. What
    /// is at odds with others, [`BoardParameters::check`] finds.
    ///
    /// ```
    /// use firmware::parameters::{BoardParameters, Value};
    /// let mut parameters = BoardParameters::DEFAULT;
    /// assert!(parameters.set(0, Value::Real(9.0)));
    /// assert!(!parameters.set(0, Value::Integer(9)));
    /// ```
    pub fn set(&mut self, number: u8, value: Value) -> bool {
        let number = usize::from(number);
        match value {
            Value::Real(value) => self.control.set(number, value),
            Value::Integer(value) => {
                let mut integers = self.integers();
                let number = number.checked_sub(CONTROL);
                let place = number.and_then(|number| integers.get_mut(number));
                let range = number.and_then(|number| RANGES.get(number));
                let (Some(place), Some(range)) = (place, range) else {
                    return false;
                };
                *place = value;
                if !range.takes(value) {
                    return false;
                }
                self.take_all(&integers);
                true
            }
        }
    }

    /// The first integer that is out of its range, by its number.
    pub(super) fn out_of_range(&self) -> Option<u8> {
        let integers = self.integers();
        let mut values = integers.iter().zip(&RANGES);
        let index = values.position(|(&value, range)| !range.takes(value))?;
        Some((CONTROL + index) as u8)
    }

    /// The value of a parameter as a word: the bits of a number of single precision, or an integer
    /// in two's complement; `None` beyond the last one.
    ///
    /// ```
    /// use firmware::parameters::BoardParameters;
    /// assert_eq!(BoardParameters::DEFAULT.word(0), Some(8_f32.to_bits()));
    /// ```
    pub fn word(&self, number: u8) -> Option<u32> {
        self.get(number).map(|value| match value {
            Value::Real(value) => value.to_bits(),
            Value::Integer(value) => value as u32,
        })
    }

    /// Sets a parameter to what [`BoardParameters::word`] gave; refuses what
    /// [`BoardParameters::set`] refuses.
    ///
    /// ```
    /// use firmware::parameters::BoardParameters;
    /// let mut parameters = BoardParameters::DEFAULT;
    /// assert!(parameters.set_word(0, 9_f32.to_bits()));
    /// assert!(!parameters.set_word(255, 0));
    /// ```
    pub fn set_word(&mut self, number: u8, word: u32) -> bool {
        let value = if usize::from(number) < CONTROL {
            Value::Real(f32::from_bits(word))
        } else {
            Value::Integer(word as i32)
        };
        self.set(number, value)
    }

    /// All parameters as words, by number.
    ///
    /// What still is a default of double precision comes back as it is; what was set to the same
    /// number of single precision comes back as the default.
    pub fn words(&self) -> [u32; WORDS] {
        let mut words = [0; WORDS];
        for (number, word) in (0..).zip(&mut words) {
            *word = self.word(number).unwrap_or(0);
        }
        words
    }

    /// What [`BoardParameters::words`] gave; `None` where it is not possible as a whole.
    pub fn from_words(words: &[u32; WORDS]) -> Option<Self> {
        let mut parameters = Self::DEFAULT;
        let are_taken = (0..)
            .zip(words)
            .all(|(number, &word)| parameters.set_word(number, word));
        (are_taken && parameters.check().is_ok()).then_some(parameters)
    }
}
