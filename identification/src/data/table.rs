//! Named columns of numbers, as read from a file.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use super::{Delimiter, ImportError, Progress, delimited, json, mat};

/// The numbers of a file, with the line of each row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// The file.
    pub path: PathBuf,
    /// The line of the header, counted from 1.
    pub header_line: u64,
    /// Names of the columns; their numbers from 1 where there is no header.
    pub names: Vec<String>,
    /// Units of the columns from a line of units; empty without such a line.
    pub units: Vec<String>,
    /// The columns. NaN is a missing number.
    pub columns: Vec<Vec<f64>>,
    /// The line of each row, counted from 1.
    pub lines: Vec<u64>,
    /// Numbers that apply to the whole file.
    pub constants: BTreeMap<String, f64>,
    /// Whether angles without a unit are in radians.
    pub radians: bool,
}

/// The format of a file, by the suffix of its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Text with one row in each line; any suffix but the others.
    Text,
    /// `.json`.
    Json,
    /// `.mat`.
    Mat,
}

impl Format {
    /// The format of the file of this name.
    ///
    /// ```
    /// use identification::data::Format;
    ///
    /// assert_eq!(Format::of("run.MAT".as_ref()), Format::Mat);
    /// assert_eq!(Format::of("run.csv".as_ref()), Format::Text);
    /// ```
    pub fn of(path: &Path) -> Self {
        let is = |suffix| {
            path.extension()
                .is_some_and(|e| e.eq_ignore_ascii_case(suffix))
        };
        match () {
            () if is("json") => Self::Json,
            () if is("mat") => Self::Mat,
            () => Self::Text,
        }
    }
}

impl Table {
    /// Reads a file; the delimiter is that of a text file.
    ///
    /// # Errors
    /// [`ImportError::Read`], and [`ImportError::Content`] for a file of another format, and a
    /// field that is not a number.
    pub fn read(
        path: &Path,
        delimiter: Option<Delimiter>,
        progress: &mut Progress<'_>,
    ) -> Result<Self, ImportError> {
        match Format::of(path) {
            Format::Text => delimited::read(path, delimiter, progress),
            Format::Json => json::read(path, progress),
            Format::Mat => mat::read(path),
        }
    }

    /// A problem at a line.
    pub fn problem(&self, line: u64, problem: impl Into<String>) -> ImportError {
        ImportError::Content {
            path: self.path.clone(),
            line: line.max(1),
            problem: problem.into(),
        }
    }

    /// The line of a row; that of the header beyond the last.
    pub fn line(&self, row: usize) -> u64 {
        self.lines.get(row).copied().unwrap_or(self.header_line)
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.lines.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }
}
