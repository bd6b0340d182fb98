//! Sequences from CSV files with a column `t` (s) and one of values.

use std::{fs::File, path::Path};

use model_core::time::{TICKS_PER_SECOND, ticks};

use super::Sequence;
use crate::error::Error;

/// The last instant that a file may name, s: four months.
const LAST_S: f64 = 1e7;

/// What a file is read for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quantity {
    /// The name of its column.
    pub column: &'static str,
    /// What stands in it, in words.
    pub meaning: &'static str,
}

/// A commanded angle.
pub const COMMAND: Quantity = Quantity {
    column: "command_deg",
    meaning: "an angle in deg",
};

/// A torque on the load.
pub const LOAD: Quantity = Quantity {
    column: "torque_nm",
    meaning: "a torque in Nm",
};

/// Reads a file. Other columns are passed over, lines that start with `#` as well.
///
/// Times do not decrease; of several rows in one tick the last counts.
///
/// # Errors
/// [`Error::Read`], and [`Error::InputFile`] with line, column and what was expected.
pub fn read(path: &Path, quantity: Quantity) -> Result<Sequence, Error> {
    let file = File::open(path).map_err(|source| Error::Read {
        path: path.into(),
        source,
    })?;
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(file);
    let columns = Columns::find(path, &mut reader, quantity)?;
    let mut sequence = Sequence::default();
    let mut record = csv::StringRecord::new();
    let mut last_s = 0.0;
    while reader
        .read_record(&mut record)
        .map_err(|error| broken(path, error))?
    {
        let at = Place {
            path,
            line: record.position().map_or(0, csv::Position::line),
        };
        let t = at.number(&record, columns.t, "t", "a time in s")?;
        let value = at.number(&record, columns.value, quantity.column, quantity.meaning)?;
        if !(0.0..=LAST_S).contains(&t) {
            return Err(at.problem(format!("t is {t}, expected 0 to {LAST_S} s")));
        }
        if t < last_s {
            return Err(at.problem(format!(
                "t is {t} after {last_s}, expected times that do not decrease"
            )));
        }
        last_s = t;
        sequence.push(ticks(t), value);
    }
    if sequence.points().is_empty() {
        let at = Place {
            path,
            line: reader.position().line(),
        };
        return Err(at.problem("no row of data, expected at least one".into()));
    }
    Ok(sequence)
}

/// Where the two columns stand.
struct Columns {
    t: usize,
    value: usize,
}

impl Columns {
    fn find(
        path: &Path,
        reader: &mut csv::Reader<File>,
        quantity: Quantity,
    ) -> Result<Self, Error> {
        let header = reader
            .headers()
            .map_err(|error| broken(path, error))?
            .clone();
        let find = |name: &str| {
            header
                .iter()
                .position(|column| column == name)
                .ok_or_else(|| {
                    let found = if header.is_empty() {
                        "the file is empty".into()
                    } else {
                        format!(
                            "the columns are `{}`",
                            header.iter().collect::<Vec<_>>().join("`, `")
                        )
                    };
                    Place { path, line: 1 }.problem(format!(
                        "no column `{name}`: {found}, expected `t` and `{}`",
                        quantity.column
                    ))
                })
        };
        Ok(Self {
            t: find("t")?,
            value: find(quantity.column)?,
        })
    }
}

/// A line of a file, for saying what is wrong there.
struct Place<'a> {
    path: &'a Path,
    line: u64,
}

impl Place<'_> {
    fn problem(&self, problem: String) -> Error {
        Error::InputFile {
            path: self.path.into(),
            line: self.line,
            problem,
        }
    }

    fn number(
        &self,
        record: &csv::StringRecord,
        index: usize,
        column: &str,
        expected: &str,
    ) -> Result<f64, Error> {
        let text = record.get(index).unwrap_or("");
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(self.problem(format!(
                "column {} (`{column}`) is `{text}`, expected {expected}",
                index + 1
            ))),
        }
    }
}

/// What the CSV reader said, with the place it said it of.
fn broken(path: &Path, error: csv::Error) -> Error {
    let line = error.position().map_or(0, csv::Position::line);
    match error.into_kind() {
        csv::ErrorKind::Io(source) => Error::Read {
            path: path.into(),
            source,
        },
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => Place { path, line }.problem(format!(
            "{len} columns, expected {expected_len} as in the header"
        )),
        csv::ErrorKind::Utf8 { err, .. } => {
            Place { path, line }.problem(format!("{err}, expected UTF-8 text"))
        }
        other => Place { path, line }.problem(format!("{other:?}, expected CSV")),
    }
}

const _: () = assert!(
    LAST_S * TICKS_PER_SECOND as f64 <= 9e15,
    "ticks are exact in f64"
);
