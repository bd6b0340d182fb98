//! A campaign: many experiments.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::sync::{Arc, Mutex};

use board_tests::program::firmware;
use virtual_board::run::{Attachments, FirmwareError, Options, RunError, Script, run_with};

pub use crate::accesses::Defect;
use crate::accesses::Layout;
use crate::experiment::OBSERVED_MS;
pub use crate::experiment::TRACE_COLUMNS;
use crate::injection::{Injection, PERIOD_INSTRUCTIONS, Place, working_memory};
use crate::injector::Injector;
use crate::motion::Motion;
use crate::outcome::Verdict;
use crate::snapshots::{Method, Report, Snapshots};
use crate::survey::{Survey, one_of_each};
use crate::timetable::Timetable;

/// Injections of the warm-up of a campaign in each of its places.
pub const WARM_UP: u64 = 6;

/// Recordings before the injections for which no experiment stands are simulated: each finds
/// another experiment that may.
const RECORDINGS: usize = 3;

/// Why a campaign ends early.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// The ELF file lacks a symbol.
    #[error(transparent)]
    Firmware(#[from] FirmwareError),
    /// The undisturbed board does not run.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A control period has no end, or more instructions than are recorded.
    #[error("{0:?}: the instructions of a control period were not recorded as a whole")]
    Period(Motion),
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

/// A skip of each instruction that a control period of a motion executes, in each motion, at one of
/// its executions that the seed decides, on a board with the warm-up [`WARM_UP`].
///
/// # Errors
/// As [`CampaignError`] says.
pub fn draw_period(seed: u64) -> Result<Vec<Injection>, CampaignError> {
    let injector = Injector::new(Vec::new());
    let timetable = timetable(WARM_UP)?;
    let limit_ms = timetable.duration_ms();
    let survey = Survey::new(timetable, injector.clone());
    let executed = run_script(survey, limit_ms, injector)?.executed;
    let is_whole = |addresses: &Vec<u32>| (addresses.len() as u64) < PERIOD_INSTRUCTIONS;
    for motion in Motion::ALL {
        if !executed.get(&motion).is_some_and(is_whole) {
            return Err(CampaignError::Period(motion));
        }
    }
    Ok(one_of_each(seed, &executed))
}

/// How injections are judged.
#[derive(Debug)]
pub enum Judged {
    /// Each by an experiment. The trace gets a line for each millisecond of it, with the columns
    /// [`TRACE_COLUMNS`].
    ByExperiments(Option<File>),
    /// By a recording of the undisturbed board, and by an experiment where that does not decide.
    ByRecording(Option<Defect>),
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

/// Judges these injections on these boards, and reports each verdict.
///
/// # Errors
/// As [`CampaignError`] says.
pub fn run_all(
    injections: &[Injection],
    boards: Boards,
    judged: Judged,
    report: impl FnMut(Injection, Verdict) + Send + 'static,
) -> Result<(), CampaignError> {
    let (mut report, mut left): (Report, _) = (Box::new(report), injections.to_vec());
    let trace = match judged {
        Judged::ByExperiments(trace) => trace,
        Judged::ByRecording(defect) => {
            let layout = Some(Layout::try_new(firmware())?);
            let method = Method { layout, defect };
            for _ in 0..RECORDINGS {
                (report, left) = run(&left, boards, method.clone(), (report, None))?;
            }
            None
        }
    };
    run(&left, boards, Method::default(), (report, trace)).map(drop)
}

/// Judges these injections. Returns those that were not judged, because no experiment stands for
/// them.
fn run(
    injections: &[Injection],
    boards: Boards,
    method: Method,
    (report, trace): (Report, Option<File>),
) -> Result<(Report, Vec<Injection>), CampaignError> {
    if injections.is_empty() {
        return Ok((report, Vec::new()));
    }
    let injector = Injector::new(working_memory(firmware())?);
    let timetable = timetable(boards.warm_up)?;
    let limit_ms = timetable.duration_ms() + u64::from(OBSERVED_MS);
    let script = Snapshots::new(
        injections.to_vec(),
        boards.processes,
        (injector.clone(), timetable),
        method,
        (report, trace),
    );
    let script = run_script(script, limit_ms, injector)?;
    script.result?;
    Ok((script.report, script.unjudged))
}

/// The timetable of all boards with so many injections of the warm-up in each of its places.
fn timetable(warm_up: u64) -> Result<Timetable, FirmwareError> {
    let mut injections = Vec::new();
    for place in [Place::Ram, Place::Registers, Place::Instruction] {
        injections.extend(draw(u64::MAX, place, 0..warm_up)?);
    }
    Ok(Timetable::new(injections))
}

/// Runs a board with this script for this time at most. Returns the script.
fn run_script<S: Script + 'static>(
    script: S,
    limit_ms: u64,
    injector: Injector,
) -> Result<S, RunError> {
    let options = Options {
        keeps_trace: false,
        ..Options::for_ms(limit_ms)
    };
    let attachments = Attachments {
        observer: Some(Arc::new(Mutex::new(injector))),
        ..Attachments::default()
    };
    Ok(run_with(firmware(), options, script, attachments)?.script)
}
