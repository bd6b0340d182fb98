//! Where results go, and how a command ends.

use std::{
    io::{self, Write},
    path::Path,
    process::ExitCode,
};

use indicatif::{ProgressBar, ProgressStyle};

use host_sim::{error::Error, table::Table};

/// Why a command ended early.
#[derive(Debug)]
pub struct Failure(Error);

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self(error)
    }
}

impl Failure {
    /// Says so on standard error, and gives the exit status.
    pub fn report(self) -> ExitCode {
        if self.is_closed_pipe() {
            return ExitCode::SUCCESS;
        }
        eprintln!("error: {}", self.0);
        match self.0 {
            Error::Bus(error) if error.is_refusal() => ExitCode::from(3),
            Error::Read { .. } | Error::Write { .. } | Error::Bus(_) | Error::Serve { .. } => {
                ExitCode::from(1)
            }
            _ => ExitCode::from(2),
        }
    }

    /// Whether the reader of our output had enough: no error of anybody.
    fn is_closed_pipe(&self) -> bool {
        matches!(&self.0, Error::Write { source, .. } if source.kind() == io::ErrorKind::BrokenPipe)
    }
}

/// Whether the name stands for standard output.
pub fn is_standard_output(path: &Path) -> bool {
    path == Path::new("-")
}

/// Writes to standard output.
pub fn print(text: &str) -> Result<(), Error> {
    let result = io::stdout().lock().write_all(text.as_bytes());
    result.map_err(|source| Error::Write {
        path: "-".into(),
        source,
    })
}

/// Writes a table to standard output, as wide as the terminal.
pub fn print_table(table: &Table) -> Result<(), Error> {
    /// Where there is no terminal: wide enough that no cell is wrapped.
    const UNBOUNDED: u16 = 1000;
    let width = terminal_size::terminal_size().map_or(UNBOUNDED, |(width, _)| width.0);
    // A table without a caption begins with an empty line.
    print(&format!("{}\n", table.to_terminal(width).trim_start()))
}

/// A progress bar on standard error; nothing where that is not a terminal.
pub fn progress(steps: u64, what: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}");
    ProgressBar::new(steps)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        .with_message(what)
}
