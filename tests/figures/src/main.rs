//! Runs every command that measures a figure of the project and writes `docs/figures.md`.
//!
//! A figure of the page is one that a test or benchmark printed, so none is typed by hand. What is
//! timed is timed in several runs with pauses between them, and the page states the least and the
//! greatest value by processor. The page names the commit, the date and the load of the machine;
//! `docs/figures.jsonl` keeps every measurement.

mod history;
mod machine;
mod measurement;
mod page;
mod timing;

use std::{fs, path::PathBuf, process::ExitCode, thread, time::Duration};

use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};

use history::Entry;
use measurement::{MEASUREMENTS, Measured};
use timing::Timings;

/// Measures the project's figures and writes them as one page
#[derive(Debug, Parser)]
struct Options {
    /// The page
    #[arg(long, value_name = "FILE", default_value = "docs/figures.md")]
    out: PathBuf,
    /// Runs of what is timed
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    runs: u16,
    /// Pause between two of these runs, s
    #[arg(long, value_name = "S", default_value_t = 60)]
    pause: u64,
    /// Keeps the counts that the page states, and measures the times alone
    #[arg(long)]
    times: bool,
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
    let machine = machine::describe();
    let counted = if options.times { 0 } else { MEASUREMENTS.len() };
    let progress = ProgressBar::new(counted as u64 + u64::from(options.runs));
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}") {
        progress.set_style(style);
    }
    let mut measured: Vec<Measured> = Vec::new();
    for measurement in &MEASUREMENTS[..counted] {
        progress.set_message(measurement.what);
        measured.push(measurement.run()?);
        progress.inc(1);
    }
    progress.set_message("times");
    let timings = Timings::prepare()?;
    let mut runs = Vec::new();
    for run in 0..options.runs {
        if run > 0 {
            thread::sleep(Duration::from_secs(options.pause));
        }
        runs.push(timings.run()?);
        progress.inc(1);
    }
    progress.finish_and_clear();
    let entry = Entry::of(&machine, &runs);
    let counts = if options.times {
        let old = fs::read_to_string(&options.out).unwrap_or_default();
        page::counts_of(&old).to_owned()
    } else {
        page::counts(&machine, &measured)
    };
    let entries = history::append(&options.out.with_extension("jsonl"), entry)?;
    let text = page::times(&entries) + &counts;
    fs::write(&options.out, text).map_err(|source| Error::Write {
        path: options.out.clone(),
        source,
    })
}
