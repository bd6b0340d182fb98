//! Runs the campaign and writes its table.

#![forbid(unsafe_code)]

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{fs, io};

use clap::Parser;
use fault_campaign::campaign::{draw, run_all};
use fault_campaign::flip::{Flip, Memory};
use fault_campaign::outcome::Outcome;
use fault_campaign::{replace_table, table};
use indicatif::{ProgressBar, ProgressStyle};
use virtual_board::run::FirmwareError;

/// Flips bits in the memory of the emulated board and judges the motion of the shaft
#[derive(Debug, Parser)]
struct Options {
    /// Flips in the RAM
    #[arg(long, value_name = "N", default_value_t = 1000)]
    ram: u64,
    /// Flips in the program's flash
    #[arg(long, value_name = "N", default_value_t = 1000)]
    code: u64,
    /// Number of the first flip of each kind
    #[arg(long, value_name = "N", default_value_t = 0)]
    first: u64,
    /// Seed of all flips
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Threads
    #[arg(long, value_name = "N", default_value_t = 2)]
    jobs: usize,
    /// Document whose table is replaced
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Why the campaign ended without a table.
#[derive(Debug, thiserror::Error)]
enum Error {
    #[error(transparent)]
    Firmware(#[from] FirmwareError),
    #[error("{}: {source}", path.display())]
    Document { path: PathBuf, source: io::Error },
    #[error("{}: the comments that enclose the table are missing", path.display())]
    NoTable { path: PathBuf },
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(hazardous) => {
            eprintln!("{hazardous} silent and hazardous");
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Runs both kinds; returns the number of silent and hazardous flips.
fn run(options: &Options) -> Result<usize, Error> {
    let ram = judged(options, Memory::Ram, options.ram)?;
    let code = judged(options, Memory::Code, options.code)?;
    let text = table(&[(Memory::Ram, &ram), (Memory::Code, &code)]);
    println!("{text}");
    if let Some(path) = &options.out {
        write(path, &text)?;
    }
    let all = ram.iter().chain(&code);
    Ok(all
        .filter(|(_, outcome)| *outcome == Outcome::Hazardous)
        .count())
}

fn judged(options: &Options, memory: Memory, count: u64) -> Result<Vec<(Flip, Outcome)>, Error> {
    let flips = draw(options.seed, memory, options.first..options.first + count)?;
    let style = ProgressStyle::with_template("{msg} {bar:40} {pos}/{len} {per_sec}, {eta} left");
    let progress = ProgressBar::new(count).with_message(format!("{memory:?}"));
    progress.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let results = run_all(&flips, options.jobs, |batch| {
        for (flip, outcome) in batch {
            if *outcome >= Outcome::Hazardous {
                progress.suspend(|| println!("{outcome:?}: {flip:x?}"));
            }
        }
        progress.inc(batch.len() as u64);
    });
    progress.finish();
    Ok(results)
}

fn write(path: &Path, text: &str) -> Result<(), Error> {
    let failed = |source| Error::Document {
        path: path.into(),
        source,
    };
    let document = fs::read_to_string(path).map_err(failed)?;
    let document =
        replace_table(&document, text).ok_or_else(|| Error::NoTable { path: path.into() })?;
    fs::write(path, document).map_err(failed)
}
