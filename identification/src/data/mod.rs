//! Imports recordings from files.
//!
//! A [`Source`] removes the envelopes of a file and determines its format; a reader for each format
//! makes a [`Table`] of it; [`Columns`] assigns quantities and units to its columns; cleaning makes
//! a [`Recording`] of it and [`Note`]s, each with its line. A problem that could be corrected only
//! by guessing is an error with file and line.

#[cfg(feature = "mcap")]
mod cdr;
mod clean;
mod clipping;
mod clock;
mod column;
mod dataflash;
mod delimited;
mod hdf5;
mod json;
mod lerobot;
pub mod lines;
mod mat;
mod matrix;
mod mcap;
mod names;
mod parquet;
mod source;
mod spreadsheet;
mod table;
mod times;
mod turns;
mod unit;

#[cfg(test)]
mod tests;

use std::{
    collections::BTreeMap,
    fmt, io,
    path::{Path, PathBuf},
};

pub use column::{ColumnSelection, Columns, Quantity};
pub use lerobot::joints_of;
pub use lines::Delimiter;
pub use source::{Format, Source};
pub use table::Table;

use super::recording::{Hold, Recording};

/// Options of the import.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Import {
    /// Assigned columns; the others are found by their usual names.
    pub columns: Columns,
    /// The delimiter of a text file; detected from its first line where it is not given.
    pub delimiter: Option<Delimiter>,
    /// The rate of samples at equal intervals, Hz; the time column is then left out.
    pub rate_hz: Option<f64>,
    /// The time window to import, s.
    pub window_s: Option<(f64, f64)>,
    /// Whether clipped samples are compared as well.
    pub keep_clipped: bool,
    /// Whether samples that look like faults of the sensor or the link are compared as well.
    pub keep_bad: bool,
    /// The hold assumption.
    pub hold: Hold,
    /// Known values of the runs by the name of a parameter; they override those of a file.
    pub constants: BTreeMap<String, f64>,
    /// Whether a recording may lack a command, because no model needs one. It then counts as
    /// commanded to its first angle.
    pub may_lack_command: bool,
}

/// A recording, with notes about its file.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The recording.
    pub recording: Recording,
    /// The irregularities, in the order of the file.
    pub notes: Vec<Note>,
}

/// An irregularity of a file that can be used nevertheless.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// The file.
    pub path: PathBuf,
    /// Its first line, counted from 1.
    pub line: u64,
    /// The irregularity, and how it was handled.
    pub text: String,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.path.display(), self.line, self.text)
    }
}

/// Why a file could not be imported.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The file could not be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The file does not have the expected content.
    #[error("{}:{line}: {problem}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: u64,
        /// The content, its column, and the expected content.
        problem: String,
    },
}

/// Receives the number of bytes read, and their total.
pub type Progress<'a> = dyn FnMut(u64, u64) + 'a;

impl Import {
    /// Reads a recording from a [`Table`] in a file.
    ///
    /// # Errors
    /// [`ImportError::Read`], and [`ImportError::Content`] for a field that is not a number, a time
    /// that decreases, or a missing column.
    pub fn read(&self, path: &Path, progress: &mut Progress<'_>) -> Result<Imported, ImportError> {
        self.recording(&Table::read(path, self.delimiter, progress)?)
    }

    /// Reads all recordings of a path: that of a file, or the episodes of a LeRobot data set in a
    /// folder.
    ///
    /// # Errors
    /// Those of [`Import::read`].
    pub fn read_all(
        &self,
        path: &Path,
        progress: &mut Progress<'_>,
    ) -> Result<Vec<Imported>, ImportError> {
        match path.is_dir() && path != Path::new("-") {
            true => lerobot::read(self, path, progress),
            false => Ok(vec![self.read(path, progress)?]),
        }
    }

    /// The recording in a table, by the rules for files.
    ///
    /// # Errors
    /// [`ImportError::Content`], as [`Import::read`].
    pub fn recording(&self, table: &Table) -> Result<Imported, ImportError> {
        let may_lack = |quantity| match quantity {
            Quantity::Time => self.rate_hz.is_some(),
            Quantity::Command => self.may_lack_command,
            Quantity::Angle => false,
            _ => true,
        };
        let (columns, ambiguous) = self.columns.of(table, may_lack)?;
        clean::recording(self, table, &columns, ambiguous)
    }
}

/// The problem of a file that this program was built without reading.
#[cfg(not(all(
    feature = "parquet",
    feature = "xlsx",
    feature = "hdf5",
    feature = "mcap"
)))]
fn not_built(what: &str) -> String {
    format!(
        "{what}, which this program was built without: `cargo build --release --features formats` \
         reads it; expected CSV, JSON or MAT of version 5, or in Python a data frame"
    )
}
