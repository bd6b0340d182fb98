//! Output of results and progress.

use std::{
    io::{self, Write},
    path::Path,
};

use indicatif::{ProgressBar, ProgressStyle};

use crate::error::Error;
use host_sim::{file::WriteError, table::Table};

/// Whether the name is that of standard output.
pub fn is_standard_output(path: &Path) -> bool {
    path == Path::new("-")
}

/// The error for a file that cannot be written; `-` is standard output.
pub fn write_error(path: &Path, source: io::Error) -> Error {
    WriteError::new(path, source).into()
}

/// Writes to standard output.
pub fn print(text: &str) -> Result<(), Error> {
    let result = io::stdout().lock().write_all(text.as_bytes());
    result.map_err(|source| write_error(Path::new("-"), source))
}

/// Writes a table to standard output, as wide as the terminal.
pub fn print_table(table: &Table) -> Result<(), Error> {
    /// The width without a terminal: no cell is wrapped.
    const UNBOUNDED: u16 = 1000;
    let width = terminal_size::terminal_size().map_or(UNBOUNDED, |(width, _)| width.0);
    // A table without a caption starts with an empty line.
    print(&format!("{}\n", table.to_terminal(width).trim_start()))
}

/// A progress bar on standard error, hidden unless that is a terminal.
pub fn progress(steps: u64, what: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}");
    ProgressBar::new(steps)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        .with_message(what)
}
