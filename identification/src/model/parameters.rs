//! The parameters of a model, each declared once.
//!
//! `parameters!` makes a struct with one field for each parameter,
//! generic over the scalar, and the table that the search, the command line and the files use. The
//! simulator's own table supplies name, symbol, unit, default, range and meaning; the declaration
//! adds properties for the search.

use std::ops::Deref;

use model_core::parameter::Parameter;

/// A parameter of a model: its declaration in the simulator, and its properties in a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelParameter {
    /// Name, symbol, unit, default, range and meaning.
    pub parameter: Parameter,
    /// Bounds of the search unless the user sets others; within the range.
    pub bounds: (f64, f64),
    /// Whether it is fixed at its starting value unless the user frees it.
    pub is_fixed: bool,
    /// Whether it is part of a recording's initial state and not of the actuator.
    pub is_initial_state: bool,
    /// Whether it is a limit, which has no effect while it is not reached.
    pub is_limit: bool,
    /// Whether it is zero unless the recordings show it: an effect that others may take the place
    /// of.
    pub is_negligible: bool,
}

impl Deref for ModelParameter {
    type Target = Parameter;

    fn deref(&self) -> &Parameter {
        &self.parameter
    }
}

impl ModelParameter {
    /// The parameter of this name in a table of the simulator, free within its range.
    ///
    /// # Panics
    /// If the table has no such parameter; at compile time where the declaration is a constant.
    pub const fn of(table: &'static [Parameter], name: &str) -> Self {
        let mut i = 0;
        while i < table.len() {
            let parameter = table[i];
            if is_equal(parameter.name.as_bytes(), name.as_bytes()) {
                return Self {
                    parameter,
                    bounds: (parameter.min, parameter.max),
                    is_fixed: false,
                    is_initial_state: false,
                    is_limit: false,
                    is_negligible: false,
                };
            }
            i += 1;
        }
        panic!("the table has no parameter of this name")
    }

    /// With a narrower range.
    pub const fn within(self, min: f64, max: f64) -> Self {
        let (min, max) = (self.parameter.min.max(min), self.parameter.max.min(max));
        self.redeclared(self.parameter.default, min, max)
    }

    /// With another default and another range, as of a quantity seen at the output shaft.
    pub const fn redeclared(mut self, default: f64, min: f64, max: f64) -> Self {
        self.parameter.default = default;
        self.parameter.min = min;
        self.parameter.max = max;
        self.bounds = (min, max);
        self
    }

    /// With search bounds that are narrower than the range.
    pub const fn searched(mut self, low: f64, high: f64) -> Self {
        self.bounds = (low, high);
        self
    }

    /// Fixed unless the user frees it.
    pub const fn fixed(mut self) -> Self {
        self.is_fixed = true;
        self
    }

    /// Part of the initial state of a recording.
    pub const fn initial_state(mut self) -> Self {
        self.is_initial_state = true;
        self
    }

    /// Zero unless the recordings show it.
    pub const fn negligible(mut self) -> Self {
        self.is_negligible = true;
        self
    }

    /// A rate limit: from below the resolution of an encoder to above the rate of any servo.
    pub const fn rate_limit(self) -> Self {
        let mut limit = self.within(0.1, 1e5);
        limit.is_limit = true;
        limit
    }
}

const fn is_equal(a: &[u8], b: &[u8]) -> bool {
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    i == a.len() && i == b.len()
}

/// The parameters of a model as a struct that `parameters!` declares.
pub trait ParameterValues<S>: Copy {
    /// The table, in the order of the fields.
    const TABLE: &'static [ModelParameter];

    /// From values in the order of the table.
    ///
    /// # Panics
    /// If their number is not that of the parameters.
    fn from_slice(values: &[S]) -> Self;

    /// The values in the order of the table.
    fn to_vec(self) -> Vec<S>;

    /// The defaults of the table.
    fn defaults() -> Self
    where
        S: From<f64>,
    {
        let defaults: Vec<S> = Self::TABLE.iter().map(|p| p.default.into()).collect();
        Self::from_slice(&defaults)
    }
}

/// Declares the parameters of a model: `name: Table.adjustment(..);`, `Table` being the simulator's
/// struct that declares a parameter of this name, and the adjustments those of [`ModelParameter`].
macro_rules! parameters {
    (
        $(#[doc = $doc:literal])+
        pub struct $Name:ident {
            $($field:ident: $Table:ident $(.$adjust:ident($($argument:expr),*))*;)+
        }
    ) => {
        $(#[doc = $doc])+
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $Name<S> {
            $(
                #[doc = concat!("As declared in [`", stringify!($Table), "`].")]
                pub $field: S,
            )+
        }

        impl<S: Copy> $crate::model::ParameterValues<S> for $Name<S> {
            const TABLE: &'static [$crate::model::ModelParameter] = &[$(
                $crate::model::ModelParameter::of(
                    <$Table as model_core::parameter::Parameters>::TABLE,
                    stringify!($field),
                )$(.$adjust($($argument),*))*,
            )+];

            fn from_slice(values: &[S]) -> Self {
                let [$($field),+] = *values else {
                    panic!("one value for each parameter")
                };
                Self { $($field),+ }
            }

            fn to_vec(self) -> Vec<S> {
                vec![$(self.$field),+]
            }
        }
    };
}

pub(crate) use parameters;
