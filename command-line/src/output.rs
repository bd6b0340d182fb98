//! Output of results and progress.

use std::{
    fmt,
    io::{self, Write},
    path::{Path, PathBuf},
    sync::atomic::{AtomicBool, Ordering::Relaxed},
};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use crate::error::Error;
use host_sim::{
    file::{self, WriteError},
    table::Table,
};

/// Whether the name is that of standard output.
pub fn is_standard_output(path: &Path) -> bool {
    path == Path::new("-")
}

/// The error for a file that cannot be written; `-` is standard output.
pub fn write_error(path: &Path, source: io::Error) -> Error {
    WriteError::new(path, source).into()
}

/// Whether a note was not written.
static IS_NOTE_LOST: AtomicBool = AtomicBool::new(false);

/// Writes a line to standard error. If that is closed or full the command continues, and ends with
/// status 1: a drive that it moves must not be left alone.
pub fn note(text: fmt::Arguments) {
    if writeln!(io::stderr().lock(), "{text}").is_err() {
        IS_NOTE_LOST.store(true, Relaxed);
    }
}

/// Whether a note was not written.
pub fn is_note_lost() -> bool {
    IS_NOTE_LOST.load(Relaxed)
}

/// Writes to standard output.
pub fn print(text: &str) -> Result<(), Error> {
    let result = io::stdout().lock().write_all(text.as_bytes());
    result.map_err(|source| write_error(Path::new("-"), source))
}

/// Results as JSON, in all commands that compute.
#[derive(Debug, Args)]
pub struct Json {
    /// Writes all results as JSON: to a file `.json`, or without one to standard output, where
    /// nothing else is printed
    #[arg(long = "json", value_name = "FILE", num_args = 0..=1, default_missing_value = "-")]
    #[arg(value_parser = json_file)]
    path: Option<PathBuf>,
}

/// A file for JSON, a pipe or a device. A file of another kind, as a recording that follows
/// `--json`, is refused.
fn json_file(name: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(name);
    let is_json = path
        .extension()
        .is_some_and(|it| it.eq_ignore_ascii_case("json"));
    let is_stream = is_standard_output(&path) || path.exists() && !path.is_file();
    match is_json || is_stream {
        true => Ok(path),
        false => Err("expected a file .json, or `-`".to_owned()),
    }
}

impl Json {
    /// That of an option without a file.
    pub fn flag(is_given: bool) -> Self {
        Self {
            path: is_given.then(|| "-".into()),
        }
    }

    /// Whether the results are written as JSON.
    pub fn is_given(&self) -> bool {
        self.path.is_some()
    }

    /// The file; `None` for standard output too.
    pub fn file(&self) -> Option<&Path> {
        let path = self.path.as_deref();
        path.filter(|path| !is_standard_output(path))
    }

    /// Writes the results: as JSON alone to standard output, or in tables and to the file.
    pub fn write(
        &self,
        json: impl FnOnce() -> String,
        tables: impl FnOnce() -> Result<(), Error>,
    ) -> Result<(), Error> {
        if self.path.is_some() && self.file().is_none() {
            return print(&json());
        }
        // First: standard output may be closed.
        let written = self.file().map(|path| (path, file::write(path, json())));
        if let Some((path, Ok(()))) = &written {
            note!("JSON: {}", path.display());
        }
        tables()?;
        match written {
            Some((_, Err(error))) => Err(error.into()),
            _ => Ok(()),
        }
    }
}

/// The width of the terminal; without one no line is too long.
pub fn width() -> usize {
    const UNBOUNDED: usize = 1000;
    terminal_size::terminal_size().map_or(UNBOUNDED, |(width, _)| width.0.into())
}

/// Writes a table to standard output, as wide as the terminal.
pub fn print_table(table: &Table) -> Result<(), Error> {
    let width = width().try_into().unwrap_or(u16::MAX);
    // A table without a caption starts with an empty line.
    print(&format!("{}\n", table.to_terminal(width).trim_start()))
}

/// Words in lines of at most `width` columns, each after `indent`. A longer word has its own line.
pub fn wrapped(text: &str, indent: &str, width: usize) -> String {
    let (mut lines, mut columns) = (String::new(), 0);
    for word in text.split(' ') {
        let length = word.chars().count();
        if columns > 0 && columns + 1 + length <= width {
            lines.push(' ');
            columns += 1 + length;
        } else {
            lines += if columns > 0 { "\n" } else { "" };
            lines += indent;
            columns = indent.len() + length;
        }
        lines += word;
    }
    lines + "\n"
}

/// A progress bar on standard error, hidden unless that is a terminal.
pub fn progress(steps: u64, what: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}");
    ProgressBar::new(steps)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        .with_message(what)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_as_long_as_allowed_and_no_word_is_lost() {
        assert_eq!(wrapped("one two three", "  ", 9), "  one two\n  three\n");
        assert_eq!(wrapped("one two three", "  ", 3), "  one\n  two\n  three\n");
        assert_eq!(wrapped("one two", "", 1000), "one two\n");
    }
}
