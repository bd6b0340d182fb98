//! Enums with named values, for command lines, files and other languages.

/// An enum with named values.
pub trait Named: Copy + Send + Sync + 'static {
    /// All values.
    const ALL: &'static [Self];

    /// The names, in the same order.
    const NAMES: &'static [&'static str];

    /// The name of the value.
    fn name(self) -> &'static str;

    /// Description in one sentence.
    fn summary(self) -> &'static str;

    /// The value with this name.
    fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|value| value.name() == name)
    }
}

/// Defines an enum with named values.
macro_rules! named {
    (
        $(#[doc = $doc:literal])+
        $Name:ident { $( $(#[doc = $summary:literal])+ $Variant:ident = $name:literal, )+ }
    ) => {
        $(#[doc = $doc])+
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub enum $Name {
            $( $(#[doc = $summary])+ $Variant, )+
        }

        impl $crate::named::Named for $Name {
            const ALL: &'static [Self] = &[$(Self::$Variant),+];
            const NAMES: &'static [&'static str] = &[$($name),+];

            fn name(self) -> &'static str {
                match self { $(Self::$Variant => $name,)+ }
            }

            fn summary(self) -> &'static str {
                match self {
                    $(Self::$Variant => $crate::parameter::trimmed(concat!($($summary),+)),)+
                }
            }
        }

        impl core::fmt::Display for $Name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.pad($crate::named::Named::name(*self))
            }
        }
    };
}

pub(crate) use named;
