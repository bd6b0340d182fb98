//! From the CSV file to its entries.

use serde::Deserialize;

use crate::row::{Access, DataType, Default, Flag, Row};
use crate::value::{Relation, StorageLocation, ValuePath};

/// What is wrong in the file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ParseError {
    /// The file is not a CSV file with the expected columns.
    #[error("{0}")]
    Csv(String),
    /// A field cannot be read.
    #[error("line {line}: {column} is \"{found}\", expected {expected}")]
    Field {
        /// Line of the file, from 1.
        line: u64,
        /// Name of the column.
        column: &'static str,
        /// Content of the field.
        found: String,
        /// What it should contain.
        expected: &'static str,
    },
    /// Entries are not sorted, or an address occurs twice.
    #[error("line {0}: the entry does not come after the one before it")]
    Order(u64),
}

/// One line of the file.
#[derive(Deserialize)]
struct Record {
    index: String,
    sub: String,
    object: String,
    entry: String,
    r#type: String,
    access: String,
    pdo: String,
    default: String,
    min: String,
    max: String,
    unit: String,
    flags: String,
    relation: String,
    value: String,
    meaning: String,
    source: String,
}

/// Default, limits and unit of a value that is declared elsewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Declared {
    /// Default.
    pub default: f32,
    /// Smallest and largest value, if both are finite.
    pub limits: Option<(String, String)>,
    /// Unit; `1` for none.
    pub unit: String,
}

/// Reads the file; `control` finds control parameters by name.
///
/// # Errors
///
/// The first line that is wrong, and why.
///
/// ```
/// let text = "index,sub,object,entry,type,access,pdo,default,min,max,unit,flags,relation,value,meaning,source\n\
///             0x6064,,Position,Position,i32,ro,x,0,,,mdeg,,,measured.position,,\n";
/// let rows = canopen_generator::parse(text, &|_| None).unwrap();
/// assert_eq!(rows[0].index, 0x6064);
/// ```
pub fn parse(
    text: &str,
    control: &dyn Fn(&str) -> Option<Declared>,
) -> Result<Vec<Row>, ParseError> {
    let mut rows: Vec<Row> = Vec::new();
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let headers = reader.headers().map_err(csv_error)?.clone();
    for record in reader.records() {
        let record = record.map_err(csv_error)?;
        let line = record.position().map_or(0, csv::Position::line);
        let record: Record = record.deserialize(Some(&headers)).map_err(csv_error)?;
        let line = Line { line, record };
        let row = line.row(control, &rows)?;
        if rows
            .last()
            .is_some_and(|last| last.address() >= row.address())
        {
            return Err(ParseError::Order(line.line));
        }
        rows.push(row);
    }
    Ok(rows)
}

fn csv_error(error: csv::Error) -> ParseError {
    ParseError::Csv(error.to_string())
}

/// An integer, hexadecimal after `0x`.
pub(crate) fn integer(text: &str) -> Option<i128> {
    match text.strip_prefix("0x") {
        Some(digits) => i128::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    }
}

struct Line {
    line: u64,
    record: Record,
}

impl Line {
    /// Reads the field `found` of a column by `read`.
    fn get<'a, T>(
        &self,
        (column, found): (&'static str, &'a str),
        expected: &'static str,
        read: impl FnOnce(&'a str) -> Option<T>,
    ) -> Result<T, ParseError> {
        read(found).ok_or_else(|| ParseError::Field {
            line: self.line,
            column,
            found: found.into(),
            expected,
        })
    }

    fn row(
        &self,
        control: &dyn Fn(&str) -> Option<Declared>,
        before: &[Row],
    ) -> Result<Row, ParseError> {
        let r = &self.record;
        let number = |text: &str| integer(text).and_then(|value| u16::try_from(value).ok());
        let name = |text: &str| (!text.is_empty()).then(|| text.to_string());
        let kind = self.get(
            ("type", &r.r#type),
            "u8 to u64, i8 to i64, f32, str or dom",
            DataType::from_name,
        )?;
        let mut row = Row {
            index: self.get(("index", &r.index), "an index such as 0x6041", number)?,
            sub: self.get(("sub", &r.sub), "nothing, or 0 to 254", |text| match text {
                "" => Some(None),
                digits => digits.parse().ok().filter(|sub| *sub < 255).map(Some),
            })?,
            object: self.get(("object", &r.object), "a name", name)?,
            entry: self.get(("entry", &r.entry), "a name", name)?,
            kind,
            access: self.get(
                ("access", &r.access),
                "const, ro, wo, rw or rww",
                Access::from_name,
            )?,
            mappable: self.get(("pdo", &r.pdo), "nothing or x", |text| match text {
                "" => Some(false),
                "x" => Some(true),
                _ => None,
            })?,
            default: self.get(("default", &r.default), "a value of the type", |text| {
                default(text, kind)
            })?,
            limits: self.limits(kind)?,
            unit: r.unit.clone(),
            flag: self.get(
                ("flags", &r.flags),
                "nothing, fixed, locked or hook",
                |text| match text {
                    "" => Some(Flag::None),
                    "fixed" => Some(Flag::Fixed),
                    "locked" => Some(Flag::Locked),
                    "hook" => Some(Flag::Hook),
                    _ => None,
                },
            )?,
            relation: self.get(
                ("relation", &r.relation),
                "nothing, or as <=0x607D:2, <0x607D:2 or in 1 2",
                relation,
            )?,
            value: None,
            meaning: r.meaning.clone(),
            source: r.source.clone(),
        };
        self.set_location(&mut row, control, before)?;
        Ok(row)
    }

    /// Sets the path of the value and the properties that are declared elsewhere.
    fn set_location(
        &self,
        row: &mut Row,
        control: &dyn Fn(&str) -> Option<Declared>,
        before: &[Row],
    ) -> Result<(), ParseError> {
        let text = ("value", self.record.value.as_str());
        // The server of the crate `canopen` holds the communication objects and all constants.
        let is_served = row.index < 0x2000
            || row.access == Access::Const
            || row.flag == Flag::Fixed
            || row.kind == DataType::Domain;
        let Some(path) = self.get(text, "the path of a value", |text| match text {
            "" if is_served => Some(None),
            text => ValuePath::from_text(text).map(Some),
        })?
        else {
            return Ok(());
        };
        let declaration = before.iter().find(|row| row.value.as_ref() == Some(&path));
        let declared = match (path.location, declaration) {
            (StorageLocation::Control, _) => {
                let declared = self.get(text, "a control parameter", |_| control(&path.field))?;
                Some((
                    match declared.default.is_finite() {
                        true => Default::Real(declared.default),
                        false => Default::None,
                    },
                    declared.limits,
                    if declared.unit == "1" {
                        String::new()
                    } else {
                        declared.unit
                    },
                ))
            }
            (StorageLocation::Parameters | StorageLocation::Values, Some(first)) => Some((
                first.default.clone(),
                first.limits.clone(),
                first.unit.clone(),
            )),
            _ => None,
        };
        if let Some(declared) = declared {
            let is_repeated = row.default != Default::None || row.limits.is_some();
            let expected = "nothing: the value is declared elsewhere";
            self.get(("default", &self.record.default), expected, |_| {
                (!is_repeated).then_some(())
            })?;
            (row.default, row.limits, row.unit) = declared;
        }
        row.value = Some(path);
        Ok(())
    }

    fn limits(&self, kind: DataType) -> Result<Option<(String, String)>, ParseError> {
        let allowed = |text: &str| text.is_empty() || default(text, kind).is_some();
        let read = |text| Some(text).filter(|text: &&str| allowed(text));
        let low = self.get(("min", &self.record.min), "a value of the type", read)?;
        let max = ("max", self.record.max.as_str());
        let high = self.get(max, "a value of the type", read)?;
        if low.is_empty() != high.is_empty() {
            return self.get(max, "both limits or none", |_| None);
        }
        Ok((!low.is_empty()).then(|| (low.to_string(), high.to_string())))
    }
}

fn default(text: &str, kind: DataType) -> Option<Default> {
    if text.is_empty() {
        return Some(Default::None);
    }
    match (kind, kind.range()) {
        (DataType::Text, _) => Some(Default::Text(text.to_string())),
        (DataType::F32, _) => text
            .parse()
            .ok()
            .filter(|value: &f32| value.is_finite())
            .map(Default::Real),
        (_, Some((low, high))) => match text.strip_prefix("$NODEID+") {
            Some(rest) if kind == DataType::U32 => {
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

fn relation(text: &str) -> Option<Option<Relation>> {
    if text.is_empty() {
        return Some(None);
    }
    Some(Some(if let Some(upper) = text.strip_prefix("<=") {
        Relation::NotAbove(address(upper)?)
    } else if let Some(upper) = text.strip_prefix('<') {
        Relation::Below(address(upper)?)
    } else {
        let values = text.strip_prefix("in ")?.split(' ');
        Relation::OneOf(
            values
                .map(|value| value.parse().ok())
                .collect::<Option<_>>()?,
        )
    }))
}

fn address(text: &str) -> Option<(u16, u8)> {
    let (index, sub) = text.split_once(':').unwrap_or((text, "0"));
    Some((integer(index)?.try_into().ok()?, sub.parse().ok()?))
}

#[cfg(test)]
mod tests;
