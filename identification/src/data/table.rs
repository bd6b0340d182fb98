//! Named columns of numbers, as read from a file.

use std::{collections::BTreeMap, path::PathBuf};

use super::ImportError;

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

impl Table {
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
