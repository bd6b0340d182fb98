//! Enums whose values have names, for command lines, files and other languages.

/// Makes an enum whose values have names.
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

        impl $Name {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$Variant),+];

            /// Their names, in the same order.
            pub const NAMES: &'static [&'static str] = &[$($name),+];

            /// The one of this name.
            pub fn named(name: &str) -> Option<Self> {
                match name {
                    $($name => Some(Self::$Variant),)+
                    _ => None,
                }
            }

            /// Its name.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$Variant => $name,)+ }
            }

            /// What it is, in a sentence.
            pub const fn summary(self) -> &'static str {
                match self {
                    $(Self::$Variant => crate::parameter::trimmed(concat!($($summary),+)),)+
                }
            }
        }

        impl core::fmt::Display for $Name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.pad(self.name())
            }
        }
    };
}

pub(crate) use named;
