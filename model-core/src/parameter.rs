//! Self-describing parameters: name, unit, default, range and source in one declaration.
//!
//! [`parameters!`](crate::parameters) defines a struct of `f64` fields together with the table that
//! a command line, a file reader or an object dictionary uses to list, read and write them.

use core::fmt;

#[cfg(feature = "serde")]
pub(crate) mod as_values;

/// Description of one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Parameter {
    /// Name, with the unit as suffix if it is simple.
    pub name: &'static str,
    /// Symbol in the paper or formula; empty if there is none.
    pub symbol: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Default value.
    pub default: f64,
    /// Smallest permitted value.
    pub min: f64,
    /// Largest permitted value; infinite if unbounded.
    pub max: f64,
    /// Source of the default.
    pub source: &'static str,
    /// Meaning in one sentence.
    pub meaning: &'static str,
}

impl Parameter {
    /// Whether `name` is the name or the symbol of this parameter.
    pub fn is_called(&self, name: &str) -> bool {
        self.name == name || (!self.symbol.is_empty() && self.symbol == name)
    }

    /// Whether the parameter selects a variant of a model and so accepts whole numbers only.
    pub const fn is_choice(&self) -> bool {
        matches!(self.unit.as_bytes(), b"choice")
    }

    /// Returns `value` if it is valid for this parameter.
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] for NaN, for a value outside `min..=max`, and for a fraction
    /// if the parameter is a choice.
    pub const fn check(&self, value: f64) -> Result<f64, ParameterError> {
        // Only a whole number is equal to itself truncated.
        if self.is_choice() && (value as i64) as f64 != value {
            return Err(ParameterError::OutOfRange {
                parameter: *self,
                value,
            });
        }
        // This form rejects NaN.
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

/// A parameter set with its table.
pub trait Parameters: Clone + Default {
    /// One row per field, in the order of the fields.
    const TABLE: &'static [Parameter];

    /// The value of row `index` of the table; `None` beyond its end.
    fn get(&self, index: usize) -> Option<f64>;

    /// Mutable access to the value of row `index` without a range check; `None` beyond the end.
    fn get_mut(&mut self, index: usize) -> Option<&mut f64>;

    /// Sets the parameter with this name or symbol.
    ///
    /// # Errors
    /// [`ParameterError::Unknown`] if no parameter has this name or symbol, and
    /// [`ParameterError::OutOfRange`] if the value is NaN or outside its range; the value is then
    /// unchanged.
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

/// The row of the parameter of this name, for constant expressions.
///
/// ```
/// use model_core::control::parameters::ControlParameters;
/// const GAIN: usize = ControlParameters::row("integral_gain");
/// assert_eq!(GAIN, 2);
/// ```
///
/// # Panics
/// The table has no such parameter; in a constant expression that is an error of the compiler.
pub const fn row(table: &[Parameter], name: &str) -> usize {
    let mut row = 0;
    while row < table.len() {
        if is_equal(table[row].name.as_bytes(), name.as_bytes()) {
            return row;
        }
        row += 1;
    }
    panic!("no parameter has this name")
}

const fn is_equal(mut a: &[u8], mut b: &[u8]) -> bool {
    while let ([first_a, rest_a @ ..], [first_b, rest_b @ ..]) = (a, b) {
        if *first_a != *first_b {
            return false;
        }
        (a, b) = (rest_a, rest_b);
    }
    a.is_empty() && b.is_empty()
}

/// Reason for which a parameter value is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ParameterError {
    /// No parameter has this name or symbol.
    Unknown,
    /// The value is NaN or outside the range.
    OutOfRange {
        /// The parameter.
        parameter: Parameter,
        /// The refused value.
        value: f64,
    },
    /// The value is not one of the allowed values.
    NotAllowed {
        /// Name of the parameter.
        name: &'static str,
        /// The refused value.
        value: f64,
        /// Description of the allowed values.
        allowed: &'static str,
    },
    /// A lower limit is above its upper limit.
    Disordered {
        /// Name of the lower limit.
        low: &'static str,
        /// Name of the upper limit.
        high: &'static str,
    },
}

/// A value in a message: with an exponent where it would have many digits.
pub struct Shown(pub f64);

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let magnitude = if self.0 < 0.0 { -self.0 } else { self.0 };
        match magnitude < f64::INFINITY && !(1e-7..1e15).contains(&magnitude) && magnitude > 0.0 {
            true => write!(f, "{:e}", self.0),
            false => write!(f, "{}", self.0),
        }
    }
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
                let has_unit = !p.is_choice() && p.unit != "1";
                let unit = if has_unit { p.unit } else { "" };
                write!(
                    f,
                    "{} is {}, expected a {kind} from {} to {}",
                    p.name,
                    Shown(*value),
                    Shown(p.min),
                    Shown(p.max)
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
                write!(f, "{name} is {}, expected {allowed}", Shown(*value))
            }
            Self::Disordered { low, high } => write!(f, "{low} is above {high}"),
        }
    }
}

impl core::error::Error for ParameterError {}

/// Defines a struct of `f64` parameters that implements [`Parameters`] and [`Default`].
///
/// ```
/// use model_core::parameter::Parameters;
///
/// model_core::parameters! {
///     /// A first-order lag.
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

/// A doc comment without its leading blank.
#[doc(hidden)]
pub const fn trimmed(text: &'static str) -> &'static str {
    text.trim_ascii()
}

/// One parameter with its present value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// Description of the parameter.
    pub parameter: &'static Parameter,
    /// Present value.
    pub value: f64,
}

/// Object-safe access to any parameter set.
pub trait Group {
    /// Descriptions of all parameters.
    fn table(&self) -> &'static [Parameter];

    /// The parameter in row `index` with its value; `None` beyond the end.
    fn value(&self, index: usize) -> Option<Value>;

    /// Sets a parameter by name or symbol.
    ///
    /// # Errors
    /// As for [`Parameters::set`].
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
    fn a_choice_accepts_whole_numbers_only() {
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
