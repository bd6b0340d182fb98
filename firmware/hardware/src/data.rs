//! Reads the CSV files.

use serde::de::DeserializeOwned;

use crate::design::{Design, Net};
use crate::rows::{Limit, NetRow, parse_pin};

/// A file that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum DataError {
    /// A row is not of the file's form.
    #[error("{file}: {error}")]
    Row {
        /// Name of the file.
        file: &'static str,
        /// Line and reason.
        error: csv::Error,
    },
    /// A field has an invalid value.
    #[error("{file}: {value:?} is not {expected}")]
    Field {
        /// Name of the file.
        file: &'static str,
        /// Content of the field.
        value: String,
        /// What it must be.
        expected: &'static str,
    },
}

fn rows<T: DeserializeOwned>(file: &'static str, text: &str) -> Result<Vec<T>, DataError> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let rows = reader.deserialize().collect::<Result<_, _>>();
    rows.map_err(|error| DataError::Row { file, error })
}

fn invalid(file: &'static str, value: &str, expected: &'static str) -> DataError {
    DataError::Field {
        file,
        value: value.to_owned(),
        expected,
    }
}

fn net(row: &NetRow) -> Result<Net, DataError> {
    let pins = row.pins.split_whitespace().map(|word| {
        let (part, pin) = word
            .split_once('.')
            .ok_or_else(|| invalid("nets.csv", word, "a part and a pin, as U1.2"))?;
        Ok((part.to_owned(), pin.to_owned()))
    });
    Ok(Net {
        board: row.board.clone(),
        name: row.net.clone(),
        pins: pins.collect::<Result<_, _>>()?,
    })
}

/// Stored parameters with a default and a largest value: what the program compares measurements
/// with is among them.
fn limits(text: &str) -> Result<Vec<Limit>, DataError> {
    const FILE: &str = "object-dictionary.csv";
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let row_error = |error| DataError::Row { file: FILE, error };
    let header = reader.headers().map_err(row_error)?.clone();
    let column = |name: &'static str| {
        let position = header.iter().position(|other| other == name);
        position.ok_or_else(|| invalid(FILE, name, "a column of the file"))
    };
    let columns = [
        column("value")?,
        column("unit")?,
        column("default")?,
        column("max")?,
    ];
    let mut found = Vec::new();
    for record in reader.records() {
        let record = record.map_err(row_error)?;
        let [path, unit, default, max] = columns.map(|index| record.get(index).unwrap_or_default());
        let Some(path) = path.strip_prefix("parameters.") else {
            continue;
        };
        if let (Ok(default), Ok(max)) = (default.parse(), max.parse()) {
            found.push(Limit {
                name: path.rsplit('.').next().unwrap_or(path).to_owned(),
                unit: unit.to_owned(),
                default,
                max,
            });
        }
    }
    Ok(found)
}

impl Design {
    /// The design as the files state it.
    ///
    /// # Errors
    /// [`DataError`] with the file and the line of a row that cannot be read.
    pub fn read() -> Result<Self, DataError> {
        let nets: Vec<NetRow> = rows("nets.csv", include_str!("../data/nets.csv"))?;
        let design = Self {
            parts: rows("parts.csv", include_str!("../data/parts.csv"))?,
            pins: rows("pins.csv", include_str!("../data/pins.csv"))?,
            nets: nets.iter().map(net).collect::<Result<_, _>>()?,
            processor: rows("processor.csv", include_str!("../data/processor.csv"))?,
            limits: limits(include_str!("../../object-dictionary.csv"))?,
            figures: rows("figures.csv", include_str!("../data/figures.csv"))?,
            rails: rows("rails.csv", include_str!("../data/rails.csv"))?,
            functions: rows("functions.csv", include_str!("../data/functions.csv"))?,
            chains: rows("chains.csv", include_str!("../data/chains.csv"))?,
            connectors: rows("connectors.csv", include_str!("../data/connectors.csv"))?,
        };
        let is_invalid = |pin: &&crate::ProcessorPin| parse_pin(&pin.pin).is_none();
        match design.processor.iter().find(is_invalid) {
            Some(row) => Err(invalid("processor.csv", &row.pin, "a pin, as PE9")),
            None => Ok(design),
        }
    }
}
