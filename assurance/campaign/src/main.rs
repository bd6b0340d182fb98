//! Runs the campaign and writes its table.

#![forbid(unsafe_code)]

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};

use board_tests::program::firmware;
use clap::Parser;
use fault_campaign::campaign::{
    Boards, CampaignError, TRACE_COLUMNS, WARM_UP, draw, draw_each, run_all,
};
use fault_campaign::class::{Class, MemoryMap};
use fault_campaign::injection::{Injection, Place};
use fault_campaign::motion::Motion;
use fault_campaign::outcome::{Outcome, Verdict};
use fault_campaign::results::{Results, program};
use fault_campaign::table;
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
    /// Sections of the ELF file of which each byte is flipped once
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    section: Vec<String>,
    /// Parts of the names of variables of which each byte is flipped once
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    symbol: Vec<String>,
    /// Motions that are disturbed; without it, all
    #[arg(long, value_name = "MOTION", value_enum, value_delimiter = ',')]
    motions: Vec<Motion>,
    /// Processes
    #[arg(long, value_name = "N", default_value_t = 2)]
    jobs: usize,
    /// CSV file of the results
    #[arg(long, value_name = "FILE")]
    results: Option<PathBuf>,
    /// CSV file of the motion, to look at a single experiment
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Page of the results
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
    Program(#[from] program_image::ImageError),
    #[error("{}: {source}", path.display())]
    Results { path: PathBuf, source: csv::Error },
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: io::Error },
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
    let map = MemoryMap::try_new(firmware())?;
    let judged = judge(options, &injections(options)?)?;
    let mut by_place: BTreeMap<Place, Vec<Verdict>> = BTreeMap::new();
    let mut by_class: BTreeMap<Class, Vec<Verdict>> = BTreeMap::new();
    for (injection, verdict) in &judged {
        by_place.entry(injection.place).or_default().push(*verdict);
        let class = by_class.entry(map.class(injection)).or_default();
        class.push(*verdict);
    }
    let places = by_place.into_iter();
    let places: Vec<_> = places
        .map(|(place, verdicts)| (place.name().to_owned(), verdicts))
        .collect();
    let classes: Vec<_> = (by_class.iter())
        .map(|(class, verdicts)| (class.name(), verdicts.clone()))
        .collect();
    let text = format!(
        "Program `{}`, seed {}.\n\n{}\n{}",
        program()?,
        options.seed,
        table(&places),
        table(&classes),
    );
    match &options.out {
        Some(path) => write_page(path, &text)?,
        None => println!("{text}"),
    }
    let verdicts = judged.iter().map(|(_, verdict)| verdict.outcome);
    Ok(verdicts.filter(|it| *it >= Outcome::Hazardous).count())
}

/// The injections that are asked for.
fn injections(options: &Options) -> Result<Vec<Injection>, CampaignError> {
    let counts = [
        (Place::Ram, options.ram),
        (Place::Code, options.code),
        (Place::Registers, options.registers),
        (Place::Instruction, options.skips),
    ];
    let mut all = Vec::new();
    for (place, count) in counts.into_iter().filter(|(_, count)| *count > 0) {
        let numbers = options.first..options.first + count;
        all.extend(draw(options.seed, place, numbers)?);
    }
    all.extend(draw_each(options.seed, &named_memory(options)?));
    let motions = &options.motions;
    all.retain(|injection| motions.is_empty() || motions.contains(&injection.motion));
    Ok(all)
}

/// The memory that is named.
fn named_memory(options: &Options) -> Result<Vec<Range<u64>>, CampaignError> {
    let mut ranges = Vec::new();
    for name in &options.section {
        let range = firmware().section(name);
        if range.is_empty() {
            return Err(CampaignError::NoSection(name.clone()));
        }
        ranges.push(range);
    }
    for name in &options.symbol {
        // An error if there is none.
        firmware().symbol_containing(name)?;
        ranges.extend(firmware().variables_containing(name));
    }
    Ok(ranges)
}

/// The verdicts, and the first error of writing one.
type Judged = (Vec<(Injection, Verdict)>, csv::Result<()>);

/// Judges the injections.
fn judge(options: &Options, injections: &[Injection]) -> Result<Vec<(Injection, Verdict)>, Error> {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} {per_sec}, {eta} left");
    let progress = ProgressBar::new(injections.len() as u64);
    progress.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let trace = options.trace.as_deref().map(create_trace).transpose()?;
    let path = options.results.clone().unwrap_or_default();
    let at = |source| Error::Results {
        path: path.clone(),
        source,
    };
    let file = options.results.as_deref().map(Results::create);
    let mut file = file.transpose().map_err(at)?;
    let judged = Arc::new(Mutex::new((Vec::new(), Ok(()))));
    let (shown, kept): (_, Arc<Mutex<Judged>>) = (progress.clone(), judged.clone());
    let report = move |injection, verdict: Verdict| {
        if verdict.outcome >= Outcome::Hazardous {
            shown.suspend(|| println!("{:?}: {injection:x?}", verdict.outcome));
        }
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.0.push((injection, verdict));
        if let Some(file) = &mut file
            && kept.1.is_ok()
        {
            kept.1 = file.add(&injection, verdict);
        }
        shown.inc(1);
    };
    let boards = Boards {
        processes: options.jobs,
        warm_up: WARM_UP,
    };
    run_all(injections, boards, trace, report)?;
    progress.finish();
    let mut judged = judged.lock().unwrap_or_else(PoisonError::into_inner);
    std::mem::replace(&mut judged.1, Ok(())).map_err(at)?;
    Ok(std::mem::take(&mut judged.0))
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

const HEAD: &str = "\
# Results of the campaign

Written by `fault-campaign --out`; `docs/trust.md` describes the campaign, its places and outcomes. The last column bounds
the rate of silent hazards with a probability of 95 %. For named memory it is a share of its bytes, each of which counts once.

";

/// Writes the page.
fn write_page(path: &Path, text: &str) -> Result<(), Error> {
    fs::write(path, format!("{HEAD}{text}")).map_err(|source| Error::File {
        path: path.into(),
        source,
    })
}
