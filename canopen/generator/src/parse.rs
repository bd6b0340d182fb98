//! From CSV to rows.

use crate::row::{Access, Default, Flag, Kind, Row};

/// What is wrong in the file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ParseError {
    /// The first line is another.
    #[error("line 1: expected the columns {HEADER}")]
    Header,
    /// A line has another number of fields.
    #[error("line {0}: expected {COLUMNS} fields without quotes, found {1}")]
    Fields(usize, usize),
    /// A field cannot be read.
    #[error("line {line}: {column} is \"{found}\", expected {expected}")]
    Field {
        /// Line of the file, from 1.
        line: usize,
        /// Name of the column.
        column: &'static str,
        /// What stands there.
        found: String,
        /// What should.
        expected: &'static str,
    },
    /// Entries are not sorted, or one stands there twice.
    #[error("line {0}: the entry does not come after the one before it")]
    Order(usize),
}

const HEADER: &str = "index,sub,object,entry,type,access,pdo,default,min,max,unit,flags,not_above";
const COLUMNS: usize = 13;

/// Reads the file.
///
/// # Errors
///
/// The first line that is wrong, and why.
///
/// ```
/// let text = "index,sub,object,entry,type,access,pdo,default,min,max,unit,flags,not_above\n\
///             0x6064,,Position,Position,i32,ro,x,0,,,mdeg,,\n";
/// assert_eq!(canopen_generator::parse(text).map(|rows| rows[0].index), Ok(0x6064));
/// ```
pub fn parse(text: &str) -> Result<Vec<Row>, ParseError> {
    let mut lines = (1..).zip(text.lines());
    if lines.next().is_none_or(|(_, header)| header != HEADER) {
        return Err(ParseError::Header);
    }
    let mut rows: Vec<Row> = Vec::new();
    for (line, text) in lines {
        let row = Fields::new(line, text)?.row()?;
        let key = |row: &Row| (row.index, row.sub_index());
        if rows.last().is_some_and(|last| key(last) >= key(&row)) {
            return Err(ParseError::Order(line));
        }
        rows.push(row);
    }
    Ok(rows)
}

/// An integer, hexadecimal after `0x`.
pub(crate) fn integer(text: &str) -> Option<i128> {
    match text.strip_prefix("0x") {
        Some(digits) => i128::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    }
}

struct Fields<'a> {
    line: usize,
    fields: [&'a str; COLUMNS],
}

impl<'a> Fields<'a> {
    fn new(line: usize, text: &'a str) -> Result<Self, ParseError> {
        let fields: Vec<_> = text.split(',').collect();
        let count = fields.len();
        let fields = fields.try_into().ok().filter(|_| !text.contains('"'));
        fields
            .map(|fields| Self { line, fields })
            .ok_or(ParseError::Fields(line, count))
    }

    /// A field, read by `read`.
    fn get<T>(
        &self,
        (at, column): (usize, &'static str),
        expected: &'static str,
        read: impl FnOnce(&'a str) -> Option<T>,
    ) -> Result<T, ParseError> {
        let found = self.fields[at];
        read(found).ok_or_else(|| ParseError::Field {
            line: self.line,
            column,
            found: found.into(),
            expected,
        })
    }

    fn row(&self) -> Result<Row, ParseError> {
        let number = |text: &str| integer(text).and_then(|value| u16::try_from(value).ok());
        let name = |text: &str| (!text.is_empty()).then(|| text.to_string());
        let kind = self.get(
            (4, "type"),
            "u8 to u64, i8 to i64, f32, str or dom",
            Kind::from_name,
        )?;
        Ok(Row {
            index: self.get((0, "index"), "an index such as 0x6041", number)?,
            sub: self.get((1, "sub"), "nothing, or 0 to 254", |text| match text {
                "" => Some(None),
                digits => digits.parse().ok().filter(|sub| *sub < 255).map(Some),
            })?,
            object: self.get((2, "object"), "a name", name)?,
            entry: self.get((3, "entry"), "a name", name)?,
            kind,
            access: self.get((5, "access"), "const, ro, wo, rw or rww", Access::from_name)?,
            mappable: self.get((6, "pdo"), "nothing or x", |text| match text {
                "" => Some(false),
                "x" => Some(true),
                _ => None,
            })?,
            default: self.get((7, "default"), "a value of the type", |text| {
                default(text, kind)
            })?,
            limits: self.limits(kind)?,
            unit: self.fields[10].to_string(),
            flag: self.get(
                (11, "flags"),
                "nothing, fixed or locked",
                |text| match text {
                    "" => Some(Flag::None),
                    "fixed" => Some(Flag::Fixed),
                    "locked" => Some(Flag::Locked),
                    _ => None,
                },
            )?,
            not_above: self.get((12, "not_above"), "nothing, or as 0x607D:2", address)?,
        })
    }

    fn limits(&self, kind: Kind) -> Result<Option<(String, String)>, ParseError> {
        let allowed = |text: &str| text.is_empty() || default(text, kind).is_some();
        let read = |text: &'a str| allowed(text).then_some(text);
        let low = self.get((8, "min"), "a value of the type", read)?;
        let high = self.get((9, "max"), "a value of the type", read)?;
        if low.is_empty() != high.is_empty() {
            return self.get((9, "max"), "both limits or none", |_| None);
        }
        Ok((!low.is_empty()).then(|| (low.to_string(), high.to_string())))
    }
}

fn default(text: &str, kind: Kind) -> Option<Default> {
    if text.is_empty() {
        return Some(Default::None);
    }
    match (kind, kind.range()) {
        (Kind::Text, _) => Some(Default::Text(text.to_string())),
        (Kind::F32, _) => text
            .parse()
            .ok()
            .filter(|value: &f32| value.is_finite())
            .map(Default::Real),
        (_, Some((low, high))) => match text.strip_prefix("$NODEID+") {
            Some(rest) if kind == Kind::U32 => {
                Some(Default::NodeId(u32::try_from(integer(rest)?).ok()?))
            }
            Some(_) => None,
            None => {
                let value = integer(text).filter(|value| (low..=high).contains(value))?;
                Some(Default::Integer(value, text.to_string()))
            }
        },
        _ => None,
    }
}

fn address(text: &str) -> Option<Option<(u16, u8)>> {
    if text.is_empty() {
        return Some(None);
    }
    let (index, sub) = text.split_once(':').unwrap_or((text, "0"));
    Some(Some((integer(index)?.try_into().ok()?, sub.parse().ok()?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(line: &str) -> String {
        parse(&format!("{HEADER}\n{line}\n"))
            .map_or_else(|error| error.to_string(), |_| "none".into())
    }

    #[test]
    fn what_is_wrong_is_told_with_line_and_column() {
        assert_eq!(error("0x2000,,A,B,u8,rw,,0,,,,,"), "none");
        assert_eq!(
            error("0x2000,,A"),
            "line 2: expected 13 fields without quotes, found 3"
        );
        assert_eq!(
            error("0x2000,,A,B,u8,rw,,256,,,,,"),
            "line 2: default is \"256\", expected a value of the type"
        );
        assert_eq!(
            error("0x2000,,A,B,u9,rw,,0,,,,,"),
            "line 2: type is \"u9\", expected u8 to u64, i8 to i64, f32, str or dom"
        );
        assert_eq!(
            error("0x2000,,A,B,u8,rw,,0,1,,,,"),
            "line 2: max is \"\", expected both limits or none"
        );
        assert_eq!(
            error("0x2000,,A,B,u8,rw,,0,,,,,\n0x2000,,A,B,u8,rw,,0,,,,,"),
            "line 3: the entry does not come after the one before it"
        );
    }

    #[test]
    fn values_are_those_of_their_type() {
        assert_eq!(
            default("-5", Kind::I8),
            Some(Default::Integer(-5, "-5".into()))
        );
        assert_eq!(
            default("$NODEID+0x180", Kind::U32),
            Some(Default::NodeId(0x180))
        );
        assert_eq!(default("$NODEID+0x180", Kind::U16), None);
        assert_eq!(default("0.5", Kind::F32), Some(Default::Real(0.5)));
        assert_eq!(default("nan", Kind::F32), None);
        assert_eq!(default("x", Kind::Domain), None);
    }
}
