//! Named columns of numbers as they stand in a file.

use std::{collections::BTreeMap, path::PathBuf};

use super::ImportError;

/// The numbers of a file, and where each row stands.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// The file.
    pub path: PathBuf,
    /// The line of the header, counted from 1.
    pub header_line: u64,
    /// Names of the columns; their numbers from 1 where there is no header.
    pub names: Vec<String>,
    /// Units of the columns where a line of their own says them; else empty.
    pub units: Vec<String>,
    /// One column a name. NaN is a number that is missing.
    pub columns: Vec<Vec<f64>>,
    /// The line of each row, counted from 1.
    pub lines: Vec<u64>,
    /// Numbers that hold for the whole file.
    pub constants: BTreeMap<String, f64>,
    /// Whether angles without a unit are radians in this kind of file.
    pub radians: bool,
}

impl Table {
    /// What is wrong at a line.
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
