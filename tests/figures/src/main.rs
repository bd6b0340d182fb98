//! Runs every command that measures a figure of the project and writes `docs/figures.md`.
//!
//! A row of the page is a line that a test or benchmark printed, so no figure is typed by hand. The
//! page names the commit, the date, the processor and the load of the machine.

mod machine;
mod measurement;
mod page;

use std::{fs, path::PathBuf, process::ExitCode};

use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};

use measurement::{MEASUREMENTS, Measured};

/// Measures the project's figures and writes them as one page
#[derive(Debug, Parser)]
struct Options {
    /// The page
    #[arg(long, value_name = "FILE", default_value = "docs/figures.md")]
    out: PathBuf,
}

/// Why the page was not written.
#[derive(Debug, thiserror::Error)]
enum Error {
    #[error("cannot run `{command}`: {source}")]
    Start {
        command: String,
        source: std::io::Error,
    },
    #[error("`{command}` failed:\n{output}")]
    Failed { command: String, output: String },
    #[error("`{command}` printed no line with \"{marker}\"")]
    NoFigure { command: String, marker: String },
    #[error("{}: {source}", path.display())]
    Write {
        path: PathBuf,
        source: std::io::Error,
    },
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<(), Error> {
    let progress = ProgressBar::new(MEASUREMENTS.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}") {
        progress.set_style(style);
    }
    let mut measured: Vec<Measured> = Vec::new();
    for measurement in &MEASUREMENTS {
        progress.set_message(measurement.what);
        measured.push(measurement.run()?);
        progress.inc(1);
    }
    progress.finish_and_clear();
    let text = page::markdown(&machine::describe(), &measured);
    fs::write(&options.out, text).map_err(|source| Error::Write {
        path: options.out.clone(),
        source,
    })
}
