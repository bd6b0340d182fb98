//! Groups of integer parameters that describe themselves, as `model_core::parameter` does it for
//! numbers of the PC: the board has no floating point of 64 bits.

/// What is known of one integer parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    /// Its name, which ends in its unit.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value unless somebody says otherwise.
    pub default: i32,
    /// Its range.
    pub range: Range,
    /// Where the default comes from.
    pub source: &'static str,
    /// What it is, in a sentence.
    pub meaning: &'static str,
}

/// The values that a parameter takes, both ends included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Range {
    /// The least one.
    pub min: i32,
    /// The greatest one.
    pub max: i32,
}

impl Range {
    /// Whether it takes this value.
    pub const fn takes(self, value: i32) -> bool {
        value >= self.min && value <= self.max
    }
}

/// A group of integer parameters.
pub trait Integers {
    /// What is known of each; only what prints it needs it.
    const TABLE: &'static [Row];

    /// The range of each: apart from the table, so that a board carries no texts.
    const RANGES: &'static [Range];

    /// Writes all values to the front; returns the rest.
    fn give<'a>(&self, values: &'a mut [i32]) -> &'a mut [i32];

    /// Takes as many values as there are rows from the front; returns the rest.
    fn take<'a>(&mut self, values: &'a [i32]) -> &'a [i32];

    /// The first row whose value is out of its range.
    fn out_of_range(&self) -> Option<usize>;

    /// The value of a row; `None` beyond the end.
    fn get(&self, row: usize) -> Option<i32>;

    /// A place to write a row, unchecked; `None` beyond the end.
    fn get_mut(&mut self, row: usize) -> Option<&mut i32>;
}

/// Makes a struct of `i32` parameters that implements [`Integers`] and [`Default`].
macro_rules! integers {
    (
        $(#[doc = $doc:literal])+
        pub struct $Name:ident {
            $(
                $(#[doc = $meaning:literal])+
                $field:ident: $default:literal, $unit:literal, $min:literal, $max:literal, $source:literal;
            )+
        }
    ) => {
        $(#[doc = $doc])+
        #[repr(C)]
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub struct $Name {
            $(
                $(#[doc = $meaning])+
                #[doc = concat!(
                    "\n\nUnit: ", $unit, ". Default: `", $default, "` (", $source, "). Range: `",
                    $min, "` to `", $max, "`.",
                )]
                pub $field: i32,
            )+
        }

        impl $Name {
            /// The defaults.
            pub const DEFAULT: Self = Self { $($field: $default,)+ };
        }

        impl Default for $Name {
            fn default() -> Self {
                Self::DEFAULT
            }
        }

        impl $crate::parameters::integers::Integers for $Name {
            const TABLE: &'static [$crate::parameters::integers::Row] = &[
                $($crate::parameters::integers::Row {
                    name: stringify!($field),
                    unit: $unit,
                    default: $default,
                    range: $crate::parameters::integers::Range { min: $min, max: $max },
                    source: $source,
                    meaning: concat!($($meaning),+).trim_ascii(),
                },)+
            ];
            const RANGES: &'static [$crate::parameters::integers::Range] = &[
                $($crate::parameters::integers::Range { min: $min, max: $max },)+
            ];

            fn give<'a>(&self, values: &'a mut [i32]) -> &'a mut [i32] {
                let own = [$(self.$field),+];
                let Some((front, rest)) = values.split_at_mut_checked(own.len()) else {
                    return &mut [];
                };
                front.copy_from_slice(&own);
                rest
            }

            fn take<'a>(&mut self, values: &'a [i32]) -> &'a [i32] {
                let rest = values;
                $(
                    let Some((&value, rest)) = rest.split_first() else {
                        return &[];
                    };
                    self.$field = value;
                )+
                rest
            }

            fn out_of_range(&self) -> Option<usize> {
                let mut rows = Self::RANGES.iter().enumerate();
                let (row, _) = rows.find(|(row, range)| {
                    self.get(*row).is_some_and(|value| !range.takes(value))
                })?;
                Some(row)
            }

            fn get(&self, row: usize) -> Option<i32> {
                [$(self.$field),+].get(row).copied()
            }

            fn get_mut(&mut self, row: usize) -> Option<&mut i32> {
                [$(&mut self.$field),+].into_iter().nth(row)
            }
        }
    };
}

pub(crate) use integers;
