//! One entry of the CSV file.

use crate::value::{Relation, ValuePath};

/// Data type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataType {
    /// UNSIGNED8.
    U8,
    /// UNSIGNED16.
    U16,
    /// UNSIGNED32.
    U32,
    /// UNSIGNED64.
    U64,
    /// INTEGER8.
    I8,
    /// INTEGER16.
    I16,
    /// INTEGER32.
    I32,
    /// INTEGER64.
    I64,
    /// REAL32.
    F32,
    /// VISIBLE_STRING.
    Text,
    /// DOMAIN: any number of bytes.
    Domain,
}

impl DataType {
    /// From the name in the file.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "u8" => Self::U8,
            "u16" => Self::U16,
            "u32" => Self::U32,
            "u64" => Self::U64,
            "i8" => Self::I8,
            "i16" => Self::I16,
            "i32" => Self::I32,
            "i64" => Self::I64,
            "f32" => Self::F32,
            "str" => Self::Text,
            "dom" => Self::Domain,
            _ => return None,
        })
    }

    /// Number of the data type, in the EDS.
    pub(crate) const fn number(self) -> u8 {
        match self {
            Self::I8 => 0x02,
            Self::I16 => 0x03,
            Self::I32 => 0x04,
            Self::U8 => 0x05,
            Self::U16 => 0x06,
            Self::U32 => 0x07,
            Self::F32 => 0x08,
            Self::Text => 0x09,
            Self::Domain => 0x0F,
            Self::I64 => 0x15,
            Self::U64 => 0x1B,
        }
    }

    /// Name of the primitive type of Rust; of a number of at most 32 bits.
    pub(crate) const fn rust_name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::U16 => "u16",
            Self::I8 => "i8",
            Self::I16 => "i16",
            Self::I32 => "i32",
            Self::F32 => "f32",
            _ => "u32",
        }
    }

    /// Name in the crate `canopen`.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::U8 => "U8",
            Self::U16 => "U16",
            Self::U32 => "U32",
            Self::U64 => "U64",
            Self::I8 => "I8",
            Self::I16 => "I16",
            Self::I32 => "I32",
            Self::I64 => "I64",
            Self::F32 => "F32",
            Self::Text => "VisibleString",
            Self::Domain => "Domain",
        }
    }

    /// Name in the standard.
    pub(crate) const fn standard_name(self) -> &'static str {
        match self {
            Self::U8 => "UNSIGNED8",
            Self::U16 => "UNSIGNED16",
            Self::U32 => "UNSIGNED32",
            Self::U64 => "UNSIGNED64",
            Self::I8 => "INTEGER8",
            Self::I16 => "INTEGER16",
            Self::I32 => "INTEGER32",
            Self::I64 => "INTEGER64",
            Self::F32 => "REAL32",
            Self::Text => "VISIBLE_STRING",
            Self::Domain => "DOMAIN",
        }
    }

    /// Smallest and largest number of an integer type.
    pub(crate) const fn range(self) -> Option<(i128, i128)> {
        Some(match self {
            Self::U8 => (0, u8::MAX as i128),
            Self::U16 => (0, u16::MAX as i128),
            Self::U32 => (0, u32::MAX as i128),
            Self::U64 => (0, u64::MAX as i128),
            Self::I8 => (i8::MIN as i128, i8::MAX as i128),
            Self::I16 => (i16::MIN as i128, i16::MAX as i128),
            Self::I32 => (i32::MIN as i128, i32::MAX as i128),
            Self::I64 => (i64::MIN as i128, i64::MAX as i128),
            Self::F32 | Self::Text | Self::Domain => return None,
        })
    }
}

/// Access, as an EDS writes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Read only, and never changes.
    Const,
    /// Read only.
    Ro,
    /// Write only.
    Wo,
    /// Read and write; read where a PDO maps it.
    Rw,
    /// Read and write; written where a PDO maps it.
    Rww,
}

impl Access {
    /// From the name in the file.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Const, Self::Ro, Self::Wo, Self::Rw, Self::Rww]
            .into_iter()
            .find(|access| access.name() == name)
    }

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Const => "const",
            Self::Ro => "ro",
            Self::Wo => "wo",
            Self::Rw => "rw",
            Self::Rww => "rww",
        }
    }
}

/// Default value.
#[derive(Clone, Debug, PartialEq)]
pub enum Default {
    /// The file has none.
    None,
    /// An integer, with its digits in the file.
    Integer(i128, String),
    /// An integer to which the node-ID is added.
    NodeId(u32),
    /// A REAL32.
    Real(f32),
    /// A text.
    Text(String),
}

/// What is special about an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flag {
    /// Nothing.
    None,
    /// Its value is the default in the table.
    Fixed,
    /// Not writable while the drive is enabled.
    Locked,
    /// Stored under its path, but read and written by code of the drive.
    Hook,
}

/// One entry.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Index.
    pub index: u16,
    /// Sub-index; `None` where the object is one variable.
    pub sub: Option<u8>,
    /// Name of the object.
    pub object: String,
    /// Name of the entry.
    pub entry: String,
    /// Data type.
    pub kind: DataType,
    /// Access.
    pub access: Access,
    /// Whether it may be mapped.
    pub mappable: bool,
    /// Default value.
    pub default: Default,
    /// Smallest and largest value, as in the file.
    pub limits: Option<(String, String)>,
    /// Unit; empty for none.
    pub unit: String,
    /// What is special about it.
    pub flag: Flag,
    /// Constraint in addition to its limits.
    pub relation: Option<Relation>,
    /// Where its value lives; `None` if the server holds it, or if it is a constant or a DOMAIN.
    pub value: Option<ValuePath>,
    /// Its meaning; empty if the name is sufficient.
    pub meaning: String,
    /// Source of its default; may be empty.
    pub source: String,
}

impl Row {
    /// Sub-index, 0 for a variable.
    #[must_use]
    pub fn sub_index(&self) -> u8 {
        self.sub.unwrap_or(0)
    }

    /// Index and sub-index.
    #[must_use]
    pub fn address(&self) -> (u16, u8) {
        (self.index, self.sub_index())
    }

    /// The object that this one must not be above, equal or not.
    pub(crate) fn upper(&self) -> Option<(u16, u8)> {
        match self.relation {
            Some(Relation::Below(upper) | Relation::NotAbove(upper)) => Some(upper),
            _ => None,
        }
    }
}
