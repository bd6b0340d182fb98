//! A campaign: many experiments.

use std::collections::BTreeSet;
use std::fs::File;
use std::io;
use std::ops::Range;
use std::sync::{Arc, Mutex};

use board_tests::program::firmware;
use virtual_board::run::{Attachments, FirmwareError, Options, RunError, run_with};

use crate::experiment::OBSERVED_MS;
pub use crate::experiment::TRACE_COLUMNS;
use crate::injection::{Injection, Place};
use crate::injector::Injector;
use crate::original::{Original, Report};
use crate::outcome::Verdict;
use crate::timetable::Timetable;

/// Injections of the warm-up of a campaign in each of its places.
pub const WARM_UP: u64 = 6;

/// Why a campaign ends early.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// The ELF file lacks a symbol.
    #[error(transparent)]
    Firmware(#[from] FirmwareError),
    /// The undisturbed board does not run.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The ELF file lacks a section, or it is empty.
    #[error("the program has no section {0}")]
    NoSection(String),
    /// A copy of the emulated board cannot be made.
    #[error("cannot copy the emulated board: {0}")]
    Copy(#[from] io::Error),
}

/// The injections with these numbers.
///
/// # Errors
/// The ELF file lacks a symbol.
pub fn draw(seed: u64, place: Place, numbers: Range<u64>) -> Result<Vec<Injection>, FirmwareError> {
    let ranges = place.ranges(firmware())?;
    Ok(numbers
        .map(|number| Injection::draw(seed, number, place, &ranges))
        .collect())
}

/// A flip in each byte of these ranges, of a bit, in a motion and at an instant that the seed decides.
pub fn draw_each(seed: u64, ranges: &[Range<u64>]) -> Vec<Injection> {
    let addresses: BTreeSet<u64> = ranges.iter().cloned().flatten().collect();
    let each = addresses.into_iter();
    each.map(|address| Injection::of_byte(seed, address))
        .collect()
}

/// The boards of a campaign.
#[derive(Debug, Clone, Copy)]
pub struct Boards {
    /// Experiments at a time.
    pub processes: usize,
    /// Injections of the warm-up in each of its places. It saves time if many experiments follow;
    /// their instants depend on it.
    pub warm_up: u64,
}

/// Judges these injections by an experiment each, and reports each verdict. The trace gets a line
/// for each millisecond of each experiment, with the columns [`TRACE_COLUMNS`].
///
/// # Errors
/// As [`CampaignError`] says.
pub fn run_all(
    injections: &[Injection],
    boards: Boards,
    trace: Option<File>,
    report: impl FnMut(Injection, Verdict) + Send + 'static,
) -> Result<(), CampaignError> {
    if injections.is_empty() {
        return Ok(());
    }
    let injector = Injector::default();
    let timetable = timetable(boards.warm_up)?;
    let limit_ms = timetable.duration_ms() + u64::from(OBSERVED_MS);
    let report: Report = Box::new(report);
    let script = Original::new(
        injections.to_vec(),
        boards.processes,
        (injector.clone(), timetable),
        (report, trace),
    );
    let options = Options {
        keeps_trace: false,
        ..Options::for_ms(limit_ms)
    };
    let attachments = Attachments {
        observer: Some(Arc::new(Mutex::new(injector))),
        ..Attachments::default()
    };
    let finished = run_with(firmware(), options, script, attachments)?;
    Ok(finished.script.result?)
}

/// The timetable of all boards with so many injections of the warm-up in each of its places.
fn timetable(warm_up: u64) -> Result<Timetable, FirmwareError> {
    let mut injections = Vec::new();
    for place in [Place::Ram, Place::Registers, Place::Instruction] {
        injections.extend(draw(u64::MAX, place, 0..warm_up)?);
    }
    Ok(Timetable::new(injections))
}
