//! Sequences from CSV files with a column `t` (s) and a column of values.

use std::{ops::RangeInclusive, path::Path};

use identification::data::lines::{Lines, TextLine};
use model_core::time::{TICKS_PER_SECOND, ticks};

use super::Sequence;
use crate::error::Error;

/// The quantity of a column.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// The name of its column.
    pub column: &'static str,
    /// Its meaning, for messages.
    pub meaning: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The values that it takes.
    pub range: RangeInclusive<f64>,
}

/// The time of a row: at most four months.
pub const TIME: Quantity = Quantity {
    column: "t",
    meaning: "a time",
    unit: "s",
    range: 0.0..=1e7,
};

const _: () = assert!(
    *TIME.range.end() * TICKS_PER_SECOND as f64 <= 9e15,
    "ticks are exact in f64"
);

/// A commanded angle, within the range of the control step.
pub const COMMAND: Quantity = Quantity {
    column: "command_deg",
    meaning: "an angle",
    unit: "deg",
    range: -32768.0..=32767.0,
};

/// A torque on the load, within the range of the constant one of the bench.
pub const LOAD: Quantity = Quantity {
    column: "torque_nm",
    meaning: "a torque",
    unit: "Nm",
    range: -100.0..=100.0,
};

/// Reads a file. Other columns, blank lines and lines that start with `#` are ignored. Fields may
/// be quoted; each row is one line.
///
/// Times do not decrease; of several rows in one tick the last applies.
///
/// # Errors
/// [`Error::Read`], and [`Error::InputFile`] with line, column and the expected value.
pub fn read(path: &Path, quantity: &Quantity) -> Result<Sequence, Error> {
    let mut lines = Lines::open(path)?;
    let expected = format!("expected a header with `t` and `{}`", quantity.column);
    let Some(header) = lines.next_line()? else {
        return Err(lines
            .problem(format!("the file is empty, {expected}"))
            .into());
    };
    let find = |name| header.column(name).map_err(|p| format!("{p}, {expected}"));
    let places = find(TIME.column).and_then(|t| Ok((t, find(quantity.column)?)));
    let (t_index, value_index) = places.map_err(|problem| header.problem(problem))?;
    let width = header.fields.len();

    let mut sequence = Sequence::default();
    let mut last_s = 0.0;
    while let Some(line) = lines.next_line()? {
        if line.fields.len() != width {
            let found = line.fields.len();
            let problem = format!("the fields are {found}, expected {width} as in the header");
            return Err(line.problem(problem).into());
        }
        let t = line.value(t_index, &TIME)?;
        if t < last_s {
            let problem = format!("t is {t} after {last_s}, expected times that do not decrease");
            return Err(line.problem(problem).into());
        }
        last_s = t;
        sequence.push(ticks(t), line.value(value_index, quantity)?);
    }
    if sequence.points().is_empty() {
        return Err(lines
            .problem("no row of data, expected at least one".into())
            .into());
    }
    Ok(sequence)
}

/// Finds columns and values by their quantities.
trait Fields {
    fn column(&self, name: &str) -> Result<usize, String>;
    fn value(&self, index: usize, quantity: &Quantity) -> Result<f64, Error>;
}

impl Fields for TextLine<'_> {
    /// The index of the column of this name.
    fn column(&self, name: &str) -> Result<usize, String> {
        let mut found = (0..self.fields.len()).filter(|&index| self.fields[index] == name);
        match (found.next(), found.next()) {
            (Some(index), None) => Ok(index),
            (Some(_), Some(_)) => Err(format!("two columns `{name}`")),
            (None, _) => {
                let columns = self.fields.join("`, `");
                Err(format!("no column `{name}`: the columns are `{columns}`"))
            }
        }
    }

    /// The number in a field.
    fn value(&self, index: usize, quantity: &Quantity) -> Result<f64, Error> {
        let text = &self.fields[index];
        match text.parse::<f64>() {
            Ok(value) if quantity.range.contains(&value) => Ok(value),
            _ => Err(Error::from(self.problem(format!(
                "column {} (`{}`) is `{text}`, expected {} from {} to {} {}",
                index + 1,
                quantity.column,
                quantity.meaning,
                quantity.range.start(),
                quantity.range.end(),
                quantity.unit
            )))),
        }
    }
}
