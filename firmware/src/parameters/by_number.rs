//! Parameters by number, as a bus asks for them, and as words, as a flash memory keeps them.
//!
//! The numbers start with the rows of
//! [`ControlParameters`](model_core::control::parameters::ControlParameters), in single precision;
//! then follow the groups of integers in the order of the fields of [`BoardParameters`].

use model_core::{
    control::{
        cascade::{COEFFICIENT_WORDS, Coefficients},
        parameters::ControlParameters,
    },
    parameter::Parameters,
};

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

/// Does the same to each group of integers, in the order of their numbers.
macro_rules! groups {
    ($($field:ident: $Group:ident),+ $(,)?) => {
        /// Parameters beyond those of the control step.
        const INTEGERS: usize = 0 $(+ <super::$Group as Integers>::RANGES.len())+;

        impl BoardParameters {
            /// The integer of this number, counted from the first integer.
            fn integer(&self, number: usize) -> Option<(i32, Range)> {
                let row = number;
                $(
                    let ranges = <super::$Group as Integers>::RANGES;
                    if let Some(&range) = ranges.get(row) {
                        return Some((self.$field.get(row)?, range));
                    }
                    let row = row.saturating_sub(ranges.len());
                )+
                let _ = row;
                None
            }

            /// Where the integer of this number stands.
            fn integer_mut(&mut self, number: usize) -> Option<&mut i32> {
                let row = number;
                $(
                    let count = <super::$Group as Integers>::RANGES.len();
                    if row < count {
                        return self.$field.get_mut(row);
                    }
                    let row = row.saturating_sub(count);
                )+
                let _ = row;
                None
            }

            /// The first integer that is out of its range, by its number.
            pub(super) fn out_of_range(&self) -> Option<u8> {
                let number = CONTROL;
                $(
                    if let Some(row) = self.$field.out_of_range() {
                        return Some((number + row) as u8);
                    }
                    let number = number + <super::$Group as Integers>::RANGES.len();
                )+
                let _ = number;
                None
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
pub const WORDS: usize = COEFFICIENT_WORDS + INTEGERS;

impl BoardParameters {
    /// How many parameters there are.
    pub const COUNT: u8 = (CONTROL + INTEGERS) as u8;

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
                let (value, _) = self.integer(number.checked_sub(CONTROL)?)?;
                Some(Value::Integer(value))
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
                let Some(number) = number.checked_sub(CONTROL) else {
                    return false;
                };
                let fits = self
                    .integer(number)
                    .is_some_and(|(_, range)| range.takes(value));
                let place = self.integer_mut(number).filter(|_| fits);
                place.map(|place| *place = value).is_some()
            }
        }
    }

    /// Everything in a fixed layout: the words of the coefficients, then the integers by number.
    pub fn words(&self) -> [u32; WORDS] {
        let control = self.control.words();
        let mut words = [0; WORDS];
        for (index, word) in words.iter_mut().enumerate() {
            *word = match control.get(index) {
                Some(&word) => word,
                None => {
                    let number = index.saturating_sub(COEFFICIENT_WORDS);
                    self.integer(number).map_or(0, |(value, _)| value as u32)
                }
            };
        }
        words
    }

    /// What [`BoardParameters::words`] gave; `None` where it is not possible as a whole.
    pub fn from_words(words: &[u32; WORDS]) -> Option<Self> {
        let (control, integers) = words.split_first_chunk::<COEFFICIENT_WORDS>()?;
        let mut parameters = Self {
            control: Coefficients::from_words(control)?,
            ..Self::DEFAULT
        };
        for (number, &word) in integers.iter().enumerate() {
            *parameters.integer_mut(number)? = word as i32;
        }
        parameters.check().is_ok().then_some(parameters)
    }
}
