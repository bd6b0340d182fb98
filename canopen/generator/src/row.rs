//! One entry as the CSV file has it.

/// Data type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// 8 bits, not negative.
    U8,
    /// 16 bits, not negative.
    U16,
    /// 32 bits, not negative.
    U32,
    /// 64 bits, not negative.
    U64,
    /// 8 bits, signed.
    I8,
    /// 16 bits, signed.
    I16,
    /// 32 bits, signed.
    I32,
    /// 64 bits, signed.
    I64,
    /// IEEE 754, single precision.
    F32,
    /// A string of visible characters.
    Text,
    /// Bytes of any number, moved by segments.
    Domain,
}

impl Kind {
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
            Self::Text => "Text",
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
    /// None is named.
    None,
    /// An integer, with the digits that the file has.
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
    /// Its value is that in the table.
    Fixed,
    /// Not to be written while the drive is enabled.
    Locked,
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
    pub kind: Kind,
    /// Access.
    pub access: Access,
    /// Whether it may be mapped.
    pub mappable: bool,
    /// Default value.
    pub default: Default,
    /// Limits as the file has them: smallest and largest.
    pub limits: Option<(String, String)>,
    /// Unit; empty where there is none.
    pub unit: String,
    /// What is special about it.
    pub flag: Flag,
    /// The object that it must not be above.
    pub not_above: Option<(u16, u8)>,
}

impl Row {
    /// Sub-index, 0 for a variable.
    #[must_use]
    pub fn sub_index(&self) -> u8 {
        self.sub.unwrap_or(0)
    }
}
