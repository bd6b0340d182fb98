//! Runs the campaign and writes its table.

#![forbid(unsafe_code)]

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};
use std::{fs, io};

use clap::Parser;
use fault_campaign::campaign::{draw, run_all};
use fault_campaign::injection::{Injection, Place};
use fault_campaign::outcome::Outcome;
use fault_campaign::results::{Results, ResultsError};
use fault_campaign::{Row, replace_table, table};
use indicatif::{ProgressBar, ProgressStyle};
use virtual_board::run::FirmwareError;

/// Injects faults into the emulated board and judges the motion of the shaft
#[derive(Debug, Parser)]
struct Options {
    /// Bits of the RAM
    #[arg(long, value_name = "N", default_value_t = 1000)]
    ram: u64,
    /// Bits of the program's flash
    #[arg(long, value_name = "N", default_value_t = 1000)]
    code: u64,
    /// Bits of the core's registers
    #[arg(long, value_name = "N", default_value_t = 1000)]
    registers: u64,
    /// Skipped instructions
    #[arg(long, value_name = "N", default_value_t = 1000)]
    skips: u64,
    /// Number of the first injection of each place
    #[arg(long, value_name = "N", default_value_t = 0)]
    first: u64,
    /// Seed of all injections
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Threads
    #[arg(long, value_name = "N", default_value_t = 2)]
    jobs: usize,
    /// CSV file of the results, which continues an earlier campaign with the same program and seed
    #[arg(long, value_name = "FILE")]
    results: Option<PathBuf>,
    /// Document whose table is replaced
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Why the campaign ended without a table.
#[derive(Debug, thiserror::Error)]
enum Error {
    #[error(transparent)]
    Firmware(#[from] FirmwareError),
    #[error(transparent)]
    Results(#[from] ResultsError),
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

/// Runs all places; returns the number of silent and hazardous injections.
fn run(options: &Options) -> Result<usize, Error> {
    let counts = [
        (Place::Ram, options.ram),
        (Place::Code, options.code),
        (Place::Registers, options.registers),
        (Place::Instruction, options.skips),
    ];
    let mut known = Results::open(options.results.as_deref(), options.seed)?;
    let mut results = Vec::new();
    for (place, count) in counts.into_iter().filter(|(_, count)| *count > 0) {
        results.push((place, judged(options, &mut known, place, count)?));
    }
    let rows: Vec<Row<'_>> = (results.iter().map(|(place, all)| (*place, &all[..]))).collect();
    let text = table(&rows);
    println!("{text}");
    if let Some(path) = &options.out {
        write(path, &text)?;
    }
    let all = results.iter().flat_map(|(_, all)| all);
    Ok(all
        .filter(|(_, outcome)| *outcome == Outcome::Hazardous)
        .count())
}

fn judged(
    options: &Options,
    known: &mut Results,
    place: Place,
    count: u64,
) -> Result<Vec<(Injection, Outcome)>, Error> {
    let injections = draw(options.seed, place, options.first..options.first + count)?;
    let is_new = |injection: &&Injection| known.outcome(place, injection.number).is_none();
    let left: Vec<_> = injections.iter().filter(is_new).copied().collect();
    let style = ProgressStyle::with_template("{msg} {bar:40} {pos}/{len} {per_sec}, {eta} left");
    let progress = ProgressBar::new(count).with_message(format!("{place:?}"));
    progress.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    progress.set_position(count - left.len() as u64);
    let kept = Mutex::new((known, Ok(())));
    run_all(&left, options.jobs, |batch| {
        for (injection, outcome) in batch {
            if *outcome >= Outcome::Hazardous {
                progress.suspend(|| println!("{outcome:?}: {injection:x?}"));
            }
        }
        let (known, result) = &mut *kept.lock().unwrap_or_else(PoisonError::into_inner);
        if result.is_ok() {
            *result = known.add(batch);
        }
        progress.inc(batch.len() as u64);
    });
    progress.finish();
    let (known, result) = kept.into_inner().unwrap_or_else(PoisonError::into_inner);
    result?;
    let outcome = |injection: Injection| {
        let outcome = known.outcome(place, injection.number);
        (injection, outcome.unwrap_or(Outcome::Unjudged))
    };
    Ok(injections.into_iter().map(outcome).collect())
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
