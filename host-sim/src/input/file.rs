//! Sequences from files with a column of times and a column of values.
//!
//! Traces and recordings are such files: columns of times and commands are found by the names and
//! units of the import of recordings.

use std::{ops::RangeInclusive, path::Path};

use identification::data::{
    self, Format, Source, Table,
    lines::{Lines, TextLine},
};
use model_core::{
    actuator::{COMMAND_RANGE, LOAD_TORQUE_RANGE_NM},
    time::{TICKS_PER_SECOND, ticks},
};

use super::Sequence;
use crate::error::Error;

/// The quantity of a column.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// The name of its column.
    pub column: &'static str,
    /// The quantity of recordings that it is: its other names and units are taken as well.
    recorded: Option<data::Quantity>,
    /// Another name of its column, with the same unit.
    alias: Option<&'static str>,
    /// Its meaning, for messages.
    pub meaning: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The values that it takes.
    pub range: RangeInclusive<f64>,
}

/// The time of a row: at most four months.
pub const TIME: Quantity = Quantity {
    column: "time_s",
    recorded: Some(data::Quantity::Time),
    alias: None,
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
    recorded: Some(data::Quantity::Command),
    alias: None,
    meaning: "an angle",
    unit: "deg",
    range: COMMAND_RANGE,
};

/// A torque on the load, within the range of the constant one of the bench.
pub const LOAD: Quantity = Quantity {
    column: "load_torque_nm",
    recorded: None,
    alias: Some("torque_nm"),
    meaning: "a torque",
    unit: "Nm",
    range: LOAD_TORQUE_RANGE_NM,
};

/// Reads a file. Other columns, blank lines and lines that start with `#` are ignored. Fields may
/// be quoted; each row is one line. The delimiter is detected in the header.
///
/// Times do not decrease; of several rows in one tick the last applies.
///
/// # Errors
/// [`Error::Read`], and [`Error::InputFile`] with line, column and the expected value.
pub fn read(path: &Path, quantity: &Quantity) -> Result<Sequence, Error> {
    let source = Source::open(path)?;
    if source.format != Format::Text {
        return of_table(&Table::of(source, None, &mut |_, _| {})?, quantity);
    }
    let mut lines = Lines::new(source, None);
    let expected = format!(
        "expected a header with `{}` and `{}`",
        TIME.column, quantity.column
    );
    let Some(header) = lines.next_line()? else {
        return Err(lines
            .problem(format!("the file is empty, {expected}"))
            .into());
    };
    let names = header.fields;
    let find = |quantity| Column::of(quantity, names).map_err(|p| format!("{p}, {expected}"));
    let columns = find(&TIME).and_then(|time| Ok((time, find(quantity)?)));
    let (time, values) = columns.map_err(|problem| header.problem(problem))?;
    let width = header.fields.len();
    lines.settle();

    let mut sequence = Sequence::default();
    let mut last_s = 0.0;
    while let Some(line) = lines.next_line()? {
        if line.fields.len() != width {
            let found = line.fields.len();
            let problem = format!("the fields are {found}, expected {width} as in the header");
            return Err(line.problem(problem).into());
        }
        let t = time.value(&line)?;
        if t < last_s {
            let name = &time.name;
            let problem =
                format!("{name} is {t} s after {last_s} s, expected times that do not decrease");
            return Err(line.problem(problem).into());
        }
        last_s = t;
        sequence.push(ticks(t), values.value(&line)?);
    }
    if sequence.points().is_empty() {
        return Err(lines
            .problem("no row of data, expected at least one".into())
            .into());
    }
    Ok(sequence)
}

/// The sequence in a table.
fn of_table(table: &Table, quantity: &Quantity) -> Result<Sequence, Error> {
    let find = |quantity| {
        let column = Column::of(quantity, &table.names);
        column.map_err(|problem| table.problem(table.header_line, problem))
    };
    let (time, values) = (find(&TIME)?, find(quantity)?);
    let mut sequence = Sequence::default();
    let mut last_s = 0.0;
    for row in 0..table.len() {
        let value = |column: &Column<'_>| {
            let value = table.columns[column.index][row] * column.factor;
            let problem = || {
                let name = &column.name;
                let expected = column.quantity.expected();
                table.problem(table.line(row), format!("{name} is {value}, {expected}"))
            };
            match column.quantity.range.contains(&value) {
                true => Ok(value),
                false => Err(problem()),
            }
        };
        let t = value(&time)?;
        if t < last_s {
            let problem = format!("{t} s after {last_s} s, expected times that do not decrease");
            return Err(table.problem(table.line(row), problem).into());
        }
        last_s = t;
        sequence.push(ticks(t), value(&values)?);
    }
    if sequence.points().is_empty() {
        let problem = "no row of data, expected at least one";
        return Err(table.problem(table.header_line, problem).into());
    }
    Ok(sequence)
}

impl Quantity {
    /// The values that it takes, for messages.
    fn expected(&self) -> String {
        let (low, high) = (self.range.start(), self.range.end());
        format!(
            "expected {} from {low} to {high} {}",
            self.meaning, self.unit
        )
    }
}

/// The column of a quantity in a file.
struct Column<'a> {
    quantity: &'a Quantity,
    index: usize,
    name: String,
    /// From its unit to that of the quantity.
    factor: f64,
}

impl<'a> Column<'a> {
    fn of(quantity: &'a Quantity, names: &[String]) -> Result<Self, String> {
        let found = match quantity.recorded {
            Some(recorded) => recorded.find(names),
            None => named(quantity, names),
        };
        let index = found.map_err(|[a, b]| {
            let meaning = quantity.meaning;
            format!("`{}` and `{}` may both be {meaning}", names[a], names[b])
        })?;
        let columns = || names.join("`, `");
        let missing = || {
            let column = quantity.column;
            format!("no column `{column}`: the columns are `{}`", columns())
        };
        let index = index.ok_or_else(missing)?;
        let name = names[index].clone();
        let factor = match quantity.recorded {
            None => 1.0,
            Some(recorded) => match (recorded.unit_in(&name), recorded) {
                (Some(factor), _) => factor,
                // A time without a unit is in seconds, as in a recording; an angle may be in
                // degrees or radians.
                (None, data::Quantity::Time) => 1.0,
                (None, _) => return Err(format!("column `{name}` has no unit")),
            },
        };
        Ok(Self {
            quantity,
            index,
            name,
            factor,
        })
    }

    /// The number in its field of a line, in the unit of the quantity.
    fn value(&self, line: &TextLine<'_>) -> Result<f64, Error> {
        let text = &line.fields[self.index];
        let value = text.parse().map(|value: f64| value * self.factor);
        let range = &self.quantity.range;
        match value {
            Ok(value) if range.contains(&value) => Ok(value),
            _ => Err(Error::from(line.problem(format!(
                "column {} (`{}`) is `{text}`, {}",
                self.index + 1,
                self.name,
                self.quantity.expected()
            )))),
        }
    }
}

/// The column that has a name of this quantity; two of them are an error.
fn named(quantity: &Quantity, names: &[String]) -> Result<Option<usize>, [usize; 2]> {
    let is_it = |name: &str| name == quantity.column || Some(name) == quantity.alias;
    let mut found = (0..names.len()).filter(|&index| is_it(&names[index]));
    match (found.next(), found.next()) {
        (Some(a), Some(b)) => Err([a, b]),
        (first, _) => Ok(first),
    }
}
