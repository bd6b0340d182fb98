//! MAT level 5, as `save -v6` writes it: one variable `trace`, a struct of column vectors beside
//! the structs `units` and `meta`.
//!
//! After MathWorks, "MAT-File Format", chapter "Level 5 MAT-File Format": "MAT-File Header Format",
//! "Data Element Format", and of "Level 5 MAT-File Data Type Formats" the numeric array, the
//! character array and the structure. The bytes are little-endian and not compressed.
//!
//! The number of rows is known in advance: the file is laid out with space for the columns, which
//! are filled as the rows arrive.

mod layout;

use std::io::{self, Seek, SeekFrom, Write};

use super::{Description, unit};
use crate::trace::Trace;
use layout::Value;

/// The greatest size of a variable without the format of version 7.3.
const MOST_BYTES: u64 = i32::MAX as u64;

/// More than the size of everything but the columns: some hundred elements below 200 bytes, and
/// the names of two files of at most 4 KiB each.
const ROOM_FOR_THE_REST: u64 = 1 << 20;

/// Rows that are buffered: 10 MB at 19 columns.
const ROWS_AT_A_TIME: usize = 1 << 16;

/// The greatest number of rows of a file.
///
/// ```
/// assert_eq!(host_sim::trace_file::mat::most_rows(8), 33_538_047);
/// ```
pub fn most_rows(columns: usize) -> u64 {
    (MOST_BYTES - ROOM_FOR_THE_REST) / (8 * columns.max(1) as u64)
}

/// A writer of MAT files.
pub struct Mat<W> {
    out: W,
    /// The position of the next number of each column.
    places: Vec<u64>,
    rows_left: u64,
    gathered: Trace,
}

impl<W: Write + Seek> Mat<W> {
    /// Lays out the file for this number of rows.
    ///
    /// # Errors
    /// Those of `out`; more than [`most_rows`] are an error too.
    pub fn create(
        out: W,
        columns: &[&'static str],
        rows: u64,
        description: &Description,
    ) -> io::Result<Self> {
        let (out, places) = layout::write(out, "trace", &variable(columns, rows, description))?;
        Ok(Self {
            out,
            places,
            rows_left: rows,
            gathered: Trace::new(columns, rows.min(ROWS_AT_A_TIME as u64) as usize),
        })
    }

    /// Writes a row.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn row(&mut self, values: &[f64]) -> io::Result<()> {
        self.gathered.push(values);
        if self.gathered.len() < ROWS_AT_A_TIME {
            return Ok(());
        }
        self.write_gathered()
    }

    /// Completes the file, and returns the underlying writer.
    ///
    /// # Errors
    /// Those of `out`.
    ///
    /// # Panics
    /// If the number of rows is not the announced one.
    pub fn finish(mut self) -> io::Result<W> {
        self.write_gathered()?;
        assert_eq!(self.rows_left, 0, "the announced number of rows");
        Ok(self.out)
    }

    fn write_gathered(&mut self) -> io::Result<()> {
        let rows = self.gathered.len() as u64;
        let left = self.rows_left.checked_sub(rows);
        self.rows_left = left.expect("no more rows than announced");
        for ((_, column), place) in self.gathered.columns().zip(&mut self.places) {
            self.out.seek(SeekFrom::Start(*place))?;
            for value in column {
                self.out.write_all(&value.to_le_bytes())?;
            }
            *place += 8 * rows;
        }
        self.gathered.clear();
        Ok(())
    }
}

/// The variable `trace`.
fn variable<'a>(columns: &[&'a str], rows: u64, description: &'a Description) -> Value<'a> {
    let columns = columns.iter().copied();
    let units = columns
        .clone()
        .map(|name| (name, Value::Text(unit::of(name))));
    let texts = description.texts.iter();
    let texts = texts.map(|(name, text)| (*name, Value::Text(text)));
    let groups = description.groups.iter().map(|(name, numbers)| {
        let numbers = numbers.iter();
        let fields = numbers.map(|(name, value)| (*name, Value::Number(*value)));
        (*name, Value::Struct(fields.collect()))
    });
    let more = [
        ("units", Value::Struct(units.clone().collect())),
        ("meta", Value::Struct(texts.chain(groups).collect())),
    ];
    let columns = columns.map(|name| (name, Value::Column(rows)));
    Value::Struct(columns.chain(more).collect())
}

#[cfg(test)]
mod tests;
