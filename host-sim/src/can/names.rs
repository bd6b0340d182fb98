//! Objects by name, index or stored value, and their values as text.

use std::sync::LazyLock;

use canopen_generator::{Access, DataType, Row, ValuePath};

use crate::error::Error;

/// The dictionary of the actuator.
static ROWS: LazyLock<Vec<Row>> =
    LazyLock::new(|| canopen_generator::actuator::rows().unwrap_or_default());

/// All objects of the actuator.
pub fn rows() -> &'static [Row] {
    &ROWS
}

/// The name of an entry: the name of its object; if that has several entries, a slash and the name
/// of the entry follow.
///
/// ```
/// use host_sim::can::names::{find, name};
/// assert_eq!(name(find("0x6064").unwrap()), "position-actual-value");
/// assert_eq!(name(find("60F9:1").unwrap()), "velocity-control-parameter-set/proportional-gain");
/// ```
pub fn name(row: &Row) -> String {
    match row.sub {
        None => kebab_case(&row.object),
        Some(_) => format!("{}/{}", kebab_case(&row.object), kebab_case(&row.entry)),
    }
}

/// Lower case with hyphens.
fn kebab_case(name: &str) -> String {
    let words = name.split(|letter: char| !letter.is_ascii_alphanumeric());
    let words: Vec<_> = words.filter(|word| !word.is_empty()).collect();
    words.join("-").to_ascii_lowercase()
}

/// An index with or without a sub-index, hexadecimal: `6064`, `0x607D:1`, `607Dh:2`.
fn address(text: &str) -> Option<(u16, u8)> {
    let (index, sub) = text.split_once(':').unwrap_or((text, "0"));
    let digits = index.trim_start_matches("0x").trim_start_matches("0X");
    let digits = digits.trim_end_matches(['h', 'H']);
    let index = (digits.len() == 4).then(|| u16::from_str_radix(digits, 16).ok())??;
    let sub = match sub.strip_prefix("0x") {
        Some(digits) => u8::from_str_radix(digits, 16).ok()?,
        None => sub.parse().ok()?,
    };
    Some((index, sub))
}

/// The entry with this name or index. The part of the name after the slash is sufficient if it is
/// unique.
///
/// # Errors
/// There is no such entry; the error suggests the most similar name.
pub fn find(text: &str) -> Result<&'static Row, Error> {
    if let Some((index, sub)) = address(text) {
        let row = rows()
            .iter()
            .find(|row| (row.index, row.sub_index()) == (index, sub));
        return row.ok_or_else(|| unknown(text));
    }
    let name_text: Vec<String> = text.split('/').map(kebab_case).collect();
    let name_text = name_text.join("/");
    if let Some(row) = rows().iter().find(|row| name(row) == name_text) {
        return Ok(row);
    }
    let mut short = rows()
        .iter()
        .filter(|row| row.sub.is_some() && kebab_case(&row.entry) == name_text);
    match (short.next(), short.next()) {
        (Some(row), None) => Ok(row),
        _ => Err(unknown(text)),
    }
}

/// The entry of a stored value, by its path in the object dictionary's source.
///
/// ```
/// use host_sim::can::names::of_value;
/// let row = of_value("values.model.gear_ratio").unwrap();
/// assert_eq!((row.index, row.sub), (0x2011, Some(3)));
/// ```
///
/// # Errors
/// No object has this value.
pub fn of_value(path: &str) -> Result<&'static Row, Error> {
    let value = ValuePath::from_text(path).ok_or_else(|| unknown(path))?;
    let mut rows = rows().iter();
    let found = rows.find(|row| row.value.as_ref() == Some(&value));
    found.ok_or_else(|| unknown(path))
}

fn unknown(text: &str) -> Error {
    let names: Vec<String> = rows().iter().map(name).collect();
    Error::unknown(
        "object",
        text,
        names.iter().map(String::as_str),
        "a name or an index such as 0x607D:1, of docs/object-dictionary.md",
    )
}

/// A value of an object.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// An integer.
    Integer(i64),
    /// A REAL32.
    Real(f32),
    /// A text.
    Text(String),
    /// Bytes of a DOMAIN.
    Bytes(Vec<u8>),
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Integer(value) => write!(f, "{value}"),
            Self::Real(value) => write!(f, "{value}"),
            Self::Text(text) => write!(f, "{text}"),
            Self::Bytes(bytes) => write!(f, "{} bytes", bytes.len()),
        }
    }
}

impl From<&Value> for serde_json::Value {
    fn from(value: &Value) -> Self {
        match value {
            Value::Integer(value) => (*value).into(),
            Value::Real(value) => serde_json::json!(value),
            Value::Text(text) => text.clone().into(),
            Value::Bytes(bytes) => bytes.clone().into(),
        }
    }
}

/// Size of a number in bytes, and whether it is signed.
pub fn layout(kind: DataType) -> Option<(usize, bool)> {
    Some(match kind {
        DataType::U8 => (1, false),
        DataType::U16 => (2, false),
        DataType::U32 => (4, false),
        DataType::U64 => (8, false),
        DataType::I8 => (1, true),
        DataType::I16 => (2, true),
        DataType::I32 => (4, true),
        DataType::I64 => (8, true),
        DataType::F32 | DataType::Text | DataType::Domain => return None,
    })
}

/// The value of these bytes; `None` if their number is wrong.
pub fn decode(kind: DataType, bytes: &[u8]) -> Option<Value> {
    match kind {
        DataType::F32 => Some(Value::Real(f32::from_le_bytes(bytes.try_into().ok()?))),
        DataType::Text => Some(Value::Text(String::from_utf8_lossy(bytes).into_owned())),
        DataType::Domain => Some(Value::Bytes(bytes.to_vec())),
        _ => {
            let (size, is_signed) = layout(kind)?;
            if bytes.len() != size {
                return None;
            }
            let mut wide = [0; 8];
            wide[..size].copy_from_slice(bytes);
            let shift = 64 - 8 * size as u32;
            let raw = i64::from_le_bytes(wide) << shift;
            let value = if is_signed {
                raw >> shift
            } else {
                (raw as u64 >> shift) as i64
            };
            Some(Value::Integer(value))
        }
    }
}

/// The bytes of a value given as text.
///
/// # Errors
/// The object is read only, or the text is not a value of its type.
pub fn encode(row: &Row, text: &str) -> Result<Vec<u8>, Error> {
    let wrong =
        |expected: &str| Error::Conflict(format!("{} is {text}, expected {expected}", name(row)));
    if matches!(row.access, Access::Const | Access::Ro) {
        return Err(Error::Conflict(format!("{} is read only", name(row))));
    }
    match row.kind {
        DataType::F32 => {
            let value: f32 = text.parse().map_err(|_| wrong("a number"))?;
            Ok(value.to_le_bytes().to_vec())
        }
        DataType::Text => Ok(text.as_bytes().to_vec()),
        DataType::Domain => Err(wrong("nothing: a DOMAIN cannot be written as text")),
        kind => {
            let (size, is_signed) = layout(kind).ok_or_else(|| wrong("a number"))?;
            let number = match text.strip_prefix("0x") {
                Some(digits) => i128::from_str_radix(digits, 16),
                None => text.parse(),
            };
            let number = number.map_err(|_| wrong("a whole number, hexadecimal behind 0x"))?;
            let bits = 8 * size as u32;
            let (least, greatest) = if is_signed {
                (-(1_i128 << (bits - 1)), (1_i128 << (bits - 1)) - 1)
            } else {
                (0, (1_i128 << bits) - 1)
            };
            if !(least..=greatest).contains(&number) {
                return Err(wrong(&format!("{least} to {greatest}")));
            }
            Ok(number.to_le_bytes()[..size].to_vec())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_are_found_by_index_by_name_and_by_a_unique_entry_name() {
        let index = |text| find(text).map(|row| (row.index, row.sub_index())).ok();
        for text in ["6041", "0x6041", "6041h", "statusword", "Statusword"] {
            assert_eq!(index(text), Some((0x6041, 0)), "{text}");
        }
        for text in [
            "607D:2",
            "0x607D:0x02",
            "Max position limit",
            "software position limit/max-position_limit",
        ] {
            assert_eq!(index(text), Some((0x607D, 2)), "{text}");
        }
        assert_eq!(index("proportional-gain"), None, "there are two");
        assert_eq!(index("60F9:99"), None);
        let error = find("statuswort").expect_err("none").to_string();
        assert!(error.contains("did you mean `statusword`"), "{error}");
    }

    #[test]
    fn values_survive_the_round_trip_through_bytes() {
        for (object, text, bytes) in [
            ("607A", "-1000", &[0x18, 0xFC, 0xFF, 0xFF][..]),
            ("6040", "0x0F", &[15, 0]),
            ("60FB:1", "8", &[0, 0, 0, 0x41]),
            ("6060", "-1", &[0xFF]),
        ] {
            let row = find(object).expect("known");
            assert_eq!(encode(row, text).expect("possible"), bytes, "{object}");
            let value = decode(row.kind, bytes).expect("whole").to_string();
            assert_eq!(value, text.replace("0x0F", "15"));
        }
        for (object, text) in [
            ("6040", "65536"),
            ("6040", "-1"),
            ("6060", "128"),
            ("607A", "x"),
            ("6041", "1"),
        ] {
            assert!(
                encode(find(object).expect("known"), text).is_err(),
                "{object} = {text}"
            );
        }
        assert_eq!(decode(DataType::U16, &[1]), None);
    }

    #[test]
    fn the_dictionary_has_all_entries() {
        assert!(rows().len() > 300);
    }
}
