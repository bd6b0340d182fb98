//! Reads JSON: a list of samples, alone or in `entries` of an object, each an object of numbers.
//!
//! The numbers next to `entries` apply to the whole run. In the recordings of Rhoban's BAM project
//! they are mass and length of the pendulum and the supply; angles are in radians there.

use std::{collections::BTreeMap, io::Read, path::Path};

use serde::Deserialize;
use serde_json::{Value, value::RawValue};

use super::{ImportError, MOST_BYTES, Progress, Table};
use crate::bounded_file::BoundedFile;

/// Names of the numbers of the whole run in these files, with those of the model parameters.
const CONSTANTS: [(&str, &str); 4] = [
    ("mass", "pendulum_mass_kg"),
    ("length", "pendulum_length_m"),
    ("vin", "supply_v"),
    ("kp", "firmware_gain"),
];

/// The samples of a file as unparsed text.
struct Samples<'a> {
    entries: Vec<&'a RawValue>,
    constants: BTreeMap<String, f64>,
    radians: bool,
}

#[derive(Deserialize)]
struct Run<'a> {
    #[serde(borrow)]
    entries: Vec<&'a RawValue>,
    #[serde(flatten)]
    rest: BTreeMap<String, Value>,
}

/// Samples between two reports of progress.
const SAMPLES_PER_REPORT: usize = 1 << 12;

/// Reads the file.
pub fn read(path: &Path, progress: &mut Progress<'_>) -> Result<Table, ImportError> {
    let mut text = String::new();
    BoundedFile::open(path, MOST_BYTES)
        .and_then(|mut file| file.read_to_string(&mut text))
        .map_err(|source| ImportError::Read {
            path: path.into(),
            source,
        })?;
    let mut table = Table {
        path: path.into(),
        header_line: 1,
        ..Table::default()
    };
    let samples = samples(&text).map_err(|error| {
        let problem = format!("column {}: {error}", error.column());
        table.problem(error.line() as u64, problem)
    })?;
    table.constants = samples.constants;
    table.radians = samples.radians;
    let (mut lines, size) = (LineNumbers::new(&text), text.len() as u64);
    for (index, entry) in samples.entries.into_iter().enumerate() {
        let line = lines.of(entry.get());
        let sample: BTreeMap<&str, Value> = serde_json::from_str(entry.get()).map_err(|error| {
            let problem = format!("sample {}: {error}, expected an object", index + 1);
            table.problem(line, problem)
        })?;
        push(&mut table, &sample);
        table.lines.push(line);
        if table.len().is_multiple_of(SAMPLES_PER_REPORT) {
            progress(lines.place as u64, size);
        }
    }
    progress(size, size);
    Ok(table)
}

fn samples(text: &str) -> Result<Samples<'_>, serde_json::Error> {
    if text.trim_start().starts_with('[') {
        return Ok(Samples {
            entries: serde_json::from_str(text)?,
            constants: BTreeMap::new(),
            radians: false,
        });
    }
    let Run { entries, rest } = serde_json::from_str(text)?;
    let known = CONSTANTS.iter();
    let constants = known.filter_map(|(theirs, ours)| {
        let value = rest.get(*theirs)?.as_f64()?;
        Some(((*ours).to_owned(), value))
    });
    Ok(Samples {
        entries,
        constants: constants.collect(),
        radians: rest.contains_key("trajectory") && rest.contains_key("motor"),
    })
}

/// Appends a sample. A new column is filled with missing numbers.
fn push(table: &mut Table, sample: &BTreeMap<&str, Value>) {
    let rows = table.lines.len();
    for (name, value) in sample {
        let value = match value {
            Value::Number(number) => number.as_f64().unwrap_or(f64::INFINITY),
            Value::Bool(flag) => f64::from(u8::from(*flag)),
            Value::Null => f64::NAN,
            // Not a number: an error only where it is used.
            _ => f64::INFINITY,
        };
        let known = table.names.iter().position(|known| known == name);
        let index = known.unwrap_or_else(|| {
            table.names.push((*name).to_owned());
            table.columns.push(vec![f64::NAN; rows]);
            table.names.len() - 1
        });
        // The first of several columns with the same name applies.
        if table.columns[index].len() == rows {
            table.columns[index].push(value);
        }
    }
    for column in &mut table.columns {
        column.resize(rows + 1, f64::NAN);
    }
}

/// Counts lines up to increasing positions.
struct LineNumbers<'a> {
    text: &'a str,
    place: usize,
    line: u64,
}

impl<'a> LineNumbers<'a> {
    fn new(text: &'a str) -> Self {
        Self {
            text,
            place: 0,
            line: 1,
        }
    }

    /// The line number of a part of the text.
    fn of(&mut self, part: &str) -> u64 {
        let place = (part.as_ptr() as usize).saturating_sub(self.text.as_ptr() as usize);
        let passed = self.text.as_bytes().get(self.place..place).unwrap_or(&[]);
        self.line += passed.iter().filter(|byte| **byte == b'\n').count() as u64;
        self.place = self.place.max(place);
        self.line
    }
}
