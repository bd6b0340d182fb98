//! Parameters that describe themselves: name, unit, default, range and source in one place.
//!
//! [`parameters!`](crate::parameters) makes a struct of `f64` fields together with the table that
//! a command line, a file reader or an object dictionary needs to list, read and write them.

use core::fmt;

#[cfg(feature = "serde")]
pub(crate) mod as_values;

/// What is known of one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Its name, which ends in its unit where the unit is simple.
    pub name: &'static str,
    /// The short symbol of the paper or of the formula; empty where there is none.
    pub symbol: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value unless somebody says otherwise.
    pub default: f64,
    /// The least value it takes.
    pub min: f64,
    /// The greatest value it takes; infinite where there is no bound.
    pub max: f64,
    /// Where the default comes from.
    pub source: &'static str,
    /// What it is, in a sentence.
    pub meaning: &'static str,
}

impl Parameter {
    /// Whether this is the parameter that somebody calls `name`, by name or by symbol.
    pub fn is_called(&self, name: &str) -> bool {
        self.name == name || (!self.symbol.is_empty() && self.symbol == name)
    }

    /// Whether only whole numbers mean something: each is another form of what is modelled.
    pub const fn is_choice(&self) -> bool {
        matches!(self.unit.as_bytes(), b"choice")
    }

    /// `value`, if this parameter can take it.
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] for NaN, for anything outside `min..=max`, and for what lies
    /// between the choices of a choice.
    pub const fn check(&self, value: f64) -> Result<f64, ParameterError> {
        // A cast toward zero and back keeps whole numbers only.
        if self.is_choice() && (value as i64) as f64 != value {
            return Err(ParameterError::OutOfRange {
                parameter: *self,
                value,
            });
        }
        // Written so that NaN fails.
        if value >= self.min && value <= self.max {
            Ok(value)
        } else {
            Err(ParameterError::OutOfRange {
                parameter: *self,
                value,
            })
        }
    }
}

/// A set of parameters with its table.
pub trait Parameters: Clone + Default {
    /// One row a field, in the order of the fields.
    const TABLE: &'static [Parameter];

    /// The value of row `index` of the table; `None` beyond its end.
    fn get(&self, index: usize) -> Option<f64>;

    /// A place to write row `index` of the table, unchecked; `None` beyond its end.
    fn get_mut(&mut self, index: usize) -> Option<&mut f64>;

    /// Sets the parameter called `name`, by name or by symbol.
    ///
    /// # Errors
    /// [`ParameterError::Unknown`] where no parameter has this name, and
    /// [`ParameterError::OutOfRange`] where the value is NaN or outside its range; nothing is
    /// changed then.
    fn set(&mut self, name: &str, value: f64) -> Result<(), ParameterError> {
        let index = Self::TABLE
            .iter()
            .position(|p| p.is_called(name))
            .ok_or(ParameterError::Unknown)?;
        let value = Self::TABLE[index].check(value)?;
        if let Some(place) = self.get_mut(index) {
            *place = value;
        }
        Ok(())
    }
}

/// Why a parameter was not taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ParameterError {
    /// No parameter has this name or symbol.
    Unknown,
    /// The value is NaN or outside the range.
    OutOfRange {
        /// The parameter that was to be set.
        parameter: Parameter,
        /// The value that it was to have.
        value: f64,
    },
    /// The value is none of the few that mean something.
    NotAllowed {
        /// Name of the parameter.
        name: &'static str,
        /// The value that it was to have.
        value: f64,
        /// The values that it takes, in words.
        allowed: &'static str,
    },
    /// A lower limit stands above its upper limit.
    Disordered {
        /// Name of the lower limit.
        low: &'static str,
        /// Name of the upper limit.
        high: &'static str,
    },
}

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown => write!(f, "no parameter has this name"),
            Self::OutOfRange {
                parameter: p,
                value,
            } => {
                let kind = if p.is_choice() {
                    "whole number"
                } else {
                    "number"
                };
                let unit = if p.is_choice() { "" } else { p.unit };
                write!(
                    f,
                    "{} is {value}, expected a {kind} from {} to {}",
                    p.name, p.min, p.max
                )?;
                if unit.is_empty() {
                    Ok(())
                } else {
                    write!(f, " {unit}")
                }
            }
            Self::NotAllowed {
                name,
                value,
                allowed,
            } => {
                write!(f, "{name} is {value}, expected {allowed}")
            }
            Self::Disordered { low, high } => write!(f, "{low} is above {high}"),
        }
    }
}

impl core::error::Error for ParameterError {}

/// Makes a struct of `f64` parameters that implements [`Parameters`] and [`Default`].
///
/// ```
/// use model_core::parameter::Parameters;
///
/// model_core::parameters! {
///     /// A lag.
///     pub struct Lag {
///         /// Time constant.
///         time_constant_s ["tau"]: 0.1, "s", 1e-4, 10.0, "an example";
///     }
/// }
///
/// let mut lag = Lag::default();
/// lag.set("tau", 0.5).unwrap();
/// assert_eq!(lag.time_constant_s, 0.5);
/// assert!(lag.set("tau", f64::NAN).is_err());
/// assert_eq!(Lag::TABLE[0].unit, "s");
/// assert_eq!(Lag::TABLE[0].meaning, "Time constant.");
/// ```
#[macro_export]
macro_rules! parameters {
    (
        $(#[doc = $doc:literal])*
        pub struct $Name:ident {
            $(
                $(#[doc = $meaning:literal])+
                $field:ident [$symbol:literal]: $default:expr, $unit:literal, $min:expr, $max:expr, $source:literal;
            )+
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $Name {
            $(
                $(#[doc = $meaning])+
                #[doc = concat!(
                    "\n\nUnit: ", $unit, ". Default: `", stringify!($default), "` (", $source, "). Range: `",
                    stringify!($min), "` to `", stringify!($max), "`.",
                )]
                pub $field: f64,
            )+
        }

        impl Default for $Name {
            fn default() -> Self {
                Self::DEFAULT
            }
        }

        impl $Name {
            /// The defaults, for constant expressions.
            pub const DEFAULT: Self = Self { $($field: $default,)+ };

            /// Checks every value against its range.
            ///
            /// # Errors
            /// [`OutOfRange`]($crate::parameter::ParameterError::OutOfRange) names the first value
            /// that is NaN or outside its range.
            pub const fn check(&self) -> Result<(), $crate::parameter::ParameterError> {
                let table = <Self as $crate::parameter::Parameters>::TABLE;
                let values = [$(self.$field),+];
                let mut i = 0;
                while i < values.len() {
                    if let Err(error) = table[i].check(values[i]) {
                        return Err(error);
                    }
                    i += 1;
                }
                Ok(())
            }
        }

        impl $crate::parameter::Parameters for $Name {
            const TABLE: &'static [$crate::parameter::Parameter] = &[
                $($crate::parameter::Parameter {
                    name: stringify!($field),
                    symbol: $symbol,
                    unit: $unit,
                    default: $default,
                    min: $min,
                    max: $max,
                    source: $source,
                    meaning: $crate::parameter::trimmed(concat!($($meaning),+)),
                },)+
            ];

            fn get(&self, index: usize) -> Option<f64> {
                [$(self.$field),+].get(index).copied()
            }

            fn get_mut(&mut self, index: usize) -> Option<&mut f64> {
                let mut fields = [$(Some(&mut self.$field)),+];
                fields.get_mut(index).and_then(Option::take)
            }
        }
    };
}

/// A doc comment without the blank that stands in front of it.
#[doc(hidden)]
pub const fn trimmed(text: &'static str) -> &'static str {
    text.trim_ascii()
}

/// One parameter with its present value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// Its row in the table.
    pub parameter: &'static Parameter,
    /// Its value.
    pub value: f64,
}

/// Parameters behind one interface, whatever their table.
pub trait Group {
    /// What is known of each of them.
    fn table(&self) -> &'static [Parameter];

    /// Row `index` of the table with its value; `None` beyond its end.
    fn value(&self, index: usize) -> Option<Value>;

    /// Sets one by name or by symbol.
    ///
    /// # Errors
    /// Those of [`Parameters::set`].
    fn assign(&mut self, name: &str, value: f64) -> Result<(), ParameterError>;
}

impl<P: Parameters> Group for P {
    fn table(&self) -> &'static [Parameter] {
        P::TABLE
    }

    fn value(&self, index: usize) -> Option<Value> {
        Some(Value {
            parameter: P::TABLE.get(index)?,
            value: self.get(index)?,
        })
    }

    fn assign(&mut self, name: &str, value: f64) -> Result<(), ParameterError> {
        self.set(name, value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    crate::parameters! {
        /// An example.
        pub struct Example {
            /// A form.
            form [""]: 1.0, "choice", 0.0, 2.0, "an example";
            /// A length.
            length_m ["l"]: 0.5, "m", 0.0, f64::INFINITY, "an example";
        }
    }

    #[test]
    fn a_choice_takes_whole_numbers_only() {
        let mut example = Example::default();
        assert_eq!(example.set("form", 2.0), Ok(()));
        for value in [0.5, 3.0, -1.0, f64::NAN] {
            assert!(example.set("form", value).is_err(), "{value}");
        }
        assert_eq!(
            std::string::ToString::to_string(&example.set("form", 0.5).unwrap_err()),
            "form is 0.5, expected a whole number from 0 to 2",
        );
    }

    #[test]
    fn a_refused_value_changes_nothing_and_names_the_range_and_the_unit() {
        let mut example = Example::default();
        assert_eq!(example.check(), Ok(()));
        let error = example.set("l", -1.0).unwrap_err();
        assert_eq!(
            std::string::ToString::to_string(&error),
            "length_m is -1, expected a number from 0 to inf m",
        );
        assert_eq!(example, Example::DEFAULT);
        assert_eq!(example.set("l", f64::INFINITY), Ok(()));
    }
}
