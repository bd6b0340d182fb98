//! Recordings from files: text with named columns, and JSON.
//!
//! A file is read into a [`Table`] of plain columns; [`Columns`] says which of them is what and in which
//! unit; cleaning turns that into a [`Recording`] and [`Note`]s, each with the line that it
//! is about. What cannot be mended without guessing is an error that names file and line.

mod clean;
mod clipping;
mod column;
mod delimited;
mod json;
pub mod lines;
mod table;
mod unit;

#[cfg(test)]
mod tests;

use std::{
    collections::BTreeMap,
    fmt, io,
    path::{Path, PathBuf},
};

pub use column::{Choice, Columns, Quantity};
pub use lines::Delimiter;
pub use table::Table;

use super::recording::{Hold, Recording};

/// How files are to be read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Import {
    /// Which column is what; the rest is found by the usual names.
    pub columns: Columns,
    /// What stands between the fields of a text file; found in its first line where it is not given.
    pub delimiter: Option<Delimiter>,
    /// From and to this time of the file alone, s.
    pub window_s: Option<(f64, f64)>,
    /// Whether samples at the end of the sensor's range are compared too.
    pub keep_clipped: bool,
    /// What the command does between its samples.
    pub hold: Hold,
    /// What is known of the runs, by the name of a model's parameter; wins over what a file says.
    pub constants: BTreeMap<String, f64>,
}

/// A recording, and what had to be said while it was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The recording.
    pub recording: Recording,
    /// Everything that was odd, in the order of the file.
    pub notes: Vec<Note>,
}

/// Something odd in a file that did not keep it from being used.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// The file.
    pub path: PathBuf,
    /// The first line that it is about, counted from 1.
    pub line: u64,
    /// What is there, and what was done about it.
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
    /// The file does not contain what was expected.
    #[error("{}:{line}: {problem}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: u64,
        /// What was found, in which column, and what was expected.
        problem: String,
    },
}

/// Is told how many bytes of how many are read.
pub type Progress<'a> = dyn FnMut(u64, u64) + 'a;

impl Import {
    /// Reads a recording: JSON where the name ends so, else text with a line a sample.
    ///
    /// # Errors
    /// [`ImportError::Read`], and [`ImportError::Content`] with file, line and what was expected: of a field
    /// that is no number, a time that goes back, a column that is missing.
    pub fn read(&self, path: &Path, progress: &mut Progress<'_>) -> Result<Imported, ImportError> {
        let is_json = path
            .extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
        let table = if is_json {
            json::read(path, progress)?
        } else {
            delimited::read(path, self.delimiter, progress)?
        };
        let columns = self.columns.of(&table)?;
        clean::recording(self, &table, &columns)
    }
}
