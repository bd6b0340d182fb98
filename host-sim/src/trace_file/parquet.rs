//! Apache Parquet: a column of required doubles for each column, and the description as metadata.
//!
//! The keys are those of the description, a group before a dot (`model`,
//! `parameters.position_gain`), and `units.COLUMN`. Pages are plain and compressed with Snappy,
//! which every reader supports.

use std::{
    io::{self, Write},
    sync::Arc,
};

use parquet::{
    basic::{Compression, Repetition, Type as PhysicalType},
    data_type::DoubleType,
    errors::ParquetError,
    file::{metadata::KeyValue, properties::WriterProperties, writer::SerializedFileWriter},
    schema::types::Type,
};

use super::{Description, unit};
use crate::trace::Trace;

/// Rows of a row group, which is buffered: 40 MB at 19 columns.
const ROWS_OF_A_GROUP: usize = 1 << 18;

/// A writer of Parquet.
pub struct Parquet<W: Write + Send> {
    writer: SerializedFileWriter<W>,
    gathered: Trace,
}

impl<W: Write + Send> Parquet<W> {
    /// Writes the head of the file.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn create(out: W, columns: &[&'static str], description: &Description) -> io::Result<Self> {
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            // A dictionary does not distinguish 0 and -0.
            .set_dictionary_enabled(false)
            .set_key_value_metadata(Some(metadata(columns, description)))
            .build();
        let schema = schema(columns).map_err(unwrapped)?;
        let writer = SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties));
        Ok(Self {
            writer: writer.map_err(unwrapped)?,
            gathered: Trace::new(columns, 0),
        })
    }

    /// Writes a row.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn row(&mut self, values: &[f64]) -> io::Result<()> {
        self.gathered.push(values);
        if self.gathered.len() < ROWS_OF_A_GROUP {
            return Ok(());
        }
        self.write_group().map_err(unwrapped)
    }

    /// Completes the file, and returns the underlying writer.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn finish(mut self) -> io::Result<W> {
        let result = self.write_group();
        result
            .and_then(|()| self.writer.into_inner())
            .map_err(unwrapped)
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        if self.gathered.is_empty() {
            return Ok(());
        }
        let mut group = self.writer.next_row_group()?;
        for (_, numbers) in self.gathered.columns() {
            if let Some(mut column) = group.next_column()? {
                column
                    .typed::<DoubleType>()
                    .write_batch(numbers, None, None)?;
                column.close()?;
            }
        }
        group.close()?;
        self.gathered.clear();
        Ok(())
    }
}

fn schema(columns: &[&str]) -> Result<Type, ParquetError> {
    let fields = columns.iter().map(|name| {
        let column = Type::primitive_type_builder(name, PhysicalType::DOUBLE);
        column
            .with_repetition(Repetition::REQUIRED)
            .build()
            .map(Arc::new)
    });
    let fields = fields.collect::<Result<_, _>>()?;
    Type::group_type_builder("trace")
        .with_fields(fields)
        .build()
}

fn metadata(columns: &[&str], description: &Description) -> Vec<KeyValue> {
    let units = columns
        .iter()
        .map(|name| (format!("units.{name}"), unit::of(name).to_owned()));
    let texts = description.texts.iter();
    let texts = texts.map(|(name, text)| ((*name).to_owned(), text.clone()));
    let numbers = description.groups.iter().flat_map(|(group, numbers)| {
        let numbers = numbers.iter();
        numbers.map(move |(name, value)| (format!("{group}.{name}"), value.to_string()))
    });
    let pairs = texts.chain(numbers).chain(units);
    pairs
        .map(|(key, value)| KeyValue::new(key, value))
        .collect()
}

/// The error of the file, if it is the source of the one of the library.
fn unwrapped(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(source) => match source.downcast::<io::Error>() {
            Ok(source) => *source,
            Err(source) => io::Error::other(source),
        },
        error => io::Error::other(error),
    }
}

#[cfg(test)]
mod tests;
