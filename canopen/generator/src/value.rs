//! Storage location and constraints of the value of an entry.

/// The store in which a value lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StorageLocation {
    /// Control parameters of `model-core`.
    Control,
    /// Integer parameters of the board.
    Parameters,
    /// Values that the drive stores in addition to the parameters.
    Values,
    /// Values with an effect.
    Command,
    /// Computed values.
    Measured,
}

impl StorageLocation {
    /// Whether the generator declares a field for it.
    pub(crate) const fn is_stored(self) -> bool {
        matches!(self, Self::Parameters | Self::Values)
    }
}

/// Where a value lives.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ValuePath {
    /// The store.
    pub location: StorageLocation,
    /// The group of a stored field; else empty.
    pub group: String,
    /// The field or the name.
    pub field: String,
}

impl ValuePath {
    /// From the text in the file.
    #[must_use]
    pub fn from_text(text: &str) -> Option<Self> {
        let (location, rest) = text.split_once('.')?;
        let location = match location {
            "control" => StorageLocation::Control,
            "parameters" => StorageLocation::Parameters,
            "values" => StorageLocation::Values,
            "command" => StorageLocation::Command,
            "measured" => StorageLocation::Measured,
            _ => return None,
        };
        let (group, field) = if location.is_stored() {
            rest.split_once('.')?
        } else {
            ("", rest)
        };
        let is_name = |name: &str| {
            name.starts_with(|c: char| c.is_ascii_lowercase())
                && name
                    .chars()
                    .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
        };
        (is_name(field) && (is_name(group) || !location.is_stored())).then(|| Self {
            location,
            group: group.to_string(),
            field: field.to_string(),
        })
    }
}

/// A constraint of a value in addition to its range.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Relation {
    /// Below the value of that object.
    Below((u16, u8)),
    /// Not above the value of that object.
    NotAbove((u16, u8)),
    /// One of these.
    OneOf(Vec<i32>),
}
