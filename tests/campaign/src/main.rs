//! Runs the campaign and writes its table.

#![forbid(unsafe_code)]

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use board_tests::program::firmware;
use clap::Parser;
use fault_campaign::campaign::{
    Boards, CampaignError, Judged, TRACE_COLUMNS, WARM_UP, draw, draw_period, run_all,
};
use fault_campaign::class::{Class, MemoryMap};
use fault_campaign::history::{Entry, update};
use fault_campaign::injection::{Injection, Place};
use fault_campaign::motion::Motion;
use fault_campaign::outcome::{Outcome, Verdict};
use fault_campaign::results::{Results, ResultsError};
use fault_campaign::{picture, replace_table, table, total};
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
    /// Each N-th instruction that a control period executes, in every motion, to be skipped once; 0
    /// for none
    #[arg(long, value_name = "N", default_value_t = 0)]
    period: usize,
    /// Motions that are disturbed; without it, all
    #[arg(long, value_name = "MOTION", value_enum, value_delimiter = ',')]
    motions: Vec<Motion>,
    /// Processes
    #[arg(long, value_name = "N", default_value_t = 2)]
    jobs: usize,
    /// CSV file of the results, which continues an earlier campaign with the same program and seed
    #[arg(long, value_name = "FILE")]
    results: Option<PathBuf>,
    /// CSV file of the counts of all campaigns, in which those of this one are replaced
    #[arg(long, value_name = "FILE")]
    history: Option<PathBuf>,
    /// Simulate each injection, also those that a recording decides
    #[arg(long)]
    simulate: bool,
    /// CSV file of the motion, to look at a single experiment
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Document whose tables are replaced, and beside it the picture of the same name
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Why the campaign ended without a table.
#[derive(Debug, thiserror::Error)]
enum Error {
    #[error(transparent)]
    Firmware(#[from] FirmwareError),
    #[error(transparent)]
    Campaign(#[from] CampaignError),
    #[error(transparent)]
    Results(#[from] ResultsError),
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: io::Error },
    #[error("{}: the comments that enclose the table are missing", path.display())]
    NoTable { path: PathBuf },
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(hazardous) => {
            eprintln!("{hazardous} silent and hazardous, or not judged");
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Runs all places; returns the number of injections that are silent and hazardous, or not judged.
fn run(options: &Options) -> Result<usize, Error> {
    let known = Results::open(options.results.as_deref(), options.seed)?;
    let program = known.program().to_owned();
    let known = Arc::new(Mutex::new((known, Ok(()))));
    let map = MemoryMap::try_new(firmware())?;
    let mut rows = Vec::new();
    let mut by_class: BTreeMap<Class, Vec<Verdict>> = BTreeMap::new();
    let mut entries = Vec::new();
    let places = injections(options)?;
    let all: Vec<Injection> = places.iter().flat_map(|(_, all)| all).copied().collect();
    judge(options, &known, &all)?;
    let known = &lock(&known).0;
    let verdict = |injection: &Injection| known.verdict(injection).unwrap_or(Verdict::UNJUDGED);
    for (place, injections) in places {
        let verdicts: Vec<Verdict> = injections.iter().map(verdict).collect();
        entries.push(Entry::new(&program, options.seed, place, &verdicts));
        for (injection, verdict) in injections.iter().zip(&verdicts) {
            let class = by_class.entry(map.class(injection)).or_default();
            class.push(*verdict);
        }
        rows.push((place.name().to_owned(), verdicts));
    }
    let classes: Vec<_> = (by_class.iter())
        .map(|(class, verdicts)| (class.name(), verdicts.clone()))
        .collect();
    let mut text = format!(
        "Program `{program}`, seed {}.\n\n{}\n{}",
        options.seed,
        table(&rows),
        table(&classes),
    );
    if let Some(path) = &options.history {
        text += &format!("\n{}", total(&update(path, &entries)?));
    }
    match &options.out {
        Some(path) => write_page(path, &text, &picture(&by_class))?,
        None => println!("{text}"),
    }
    let verdicts = rows.iter().flat_map(|(_, verdicts)| verdicts);
    Ok(verdicts
        .filter(|verdict| verdict.outcome >= Outcome::Hazardous)
        .count())
}

/// The injections that are asked for, place by place.
fn injections(options: &Options) -> Result<Vec<(Place, Vec<Injection>)>, CampaignError> {
    let counts = [
        (Place::Ram, options.ram),
        (Place::Code, options.code),
        (Place::Registers, options.registers),
        (Place::Instruction, options.skips),
    ];
    let mut all = Vec::new();
    for (place, count) in counts.into_iter().filter(|(_, count)| *count > 0) {
        let numbers = options.first..options.first + count;
        all.push((place, draw(options.seed, place, numbers)?));
    }
    if options.period > 0 {
        let drawn = draw_period(options.seed)?.into_iter();
        all.push((Place::Period, drawn.step_by(options.period).collect()));
    }
    let motions = &options.motions;
    for (_, injections) in &mut all {
        injections.retain(|injection| motions.is_empty() || motions.contains(&injection.motion));
    }
    Ok(all)
}

/// The known results, and the first error of writing one.
type Known = Arc<Mutex<(Results, Result<(), ResultsError>)>>;

fn lock(known: &Known) -> MutexGuard<'_, (Results, Result<(), ResultsError>)> {
    known.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Judges those of the injections that are not known.
fn judge(options: &Options, known: &Known, injections: &[Injection]) -> Result<(), Error> {
    let is_new = |injection: &&Injection| lock(known).0.verdict(injection).is_none();
    let left: Vec<_> = injections.iter().filter(is_new).copied().collect();
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} {per_sec}, {eta} left");
    let progress = ProgressBar::new(left.len() as u64);
    progress.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let trace = options.trace.as_deref().map(create_trace).transpose()?;
    let (shown, results) = (progress.clone(), known.clone());
    let report = move |injection, verdict: Verdict| {
        if verdict.outcome >= Outcome::Hazardous {
            shown.suspend(|| println!("{:?}: {injection:x?}", verdict.outcome));
        }
        let (results, result) = &mut *lock(&results);
        if result.is_ok() {
            *result = results.add(&injection, verdict);
        }
        shown.inc(1);
    };
    let judged = if options.simulate || trace.is_some() {
        Judged::ByExperiments(trace)
    } else {
        Judged::ByRecording(None)
    };
    let boards = Boards {
        processes: options.jobs,
        warm_up: WARM_UP,
    };
    run_all(&left, boards, judged, report)?;
    progress.finish();
    Ok(std::mem::replace(&mut lock(known).1, Ok(()))?)
}

fn create_trace(path: &Path) -> Result<File, Error> {
    let created = File::create(path).and_then(|mut file| {
        file.write_all(TRACE_COLUMNS.as_bytes())?;
        Ok(file)
    });
    created.map_err(|source| Error::File {
        path: path.into(),
        source,
    })
}

/// Replaces the tables of the document, and writes the picture beside it.
fn write_page(path: &Path, text: &str, picture: &str) -> Result<(), Error> {
    let write = |path: &Path, text: &str| {
        fs::write(path, text).map_err(|source| Error::File {
            path: path.into(),
            source,
        })
    };
    let document = fs::read_to_string(path).map_err(|source| Error::File {
        path: path.into(),
        source,
    })?;
    let document =
        replace_table(&document, text).ok_or_else(|| Error::NoTable { path: path.into() })?;
    write(path, &document)?;
    write(&path.with_extension("svg"), picture)
}
