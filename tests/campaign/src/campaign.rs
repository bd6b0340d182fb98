//! A campaign: many experiments on several threads.

use std::sync::Mutex;
use std::thread;

use board_tests::program::firmware;
use virtual_board::run::{FirmwareError, Options, run};

use crate::experiment::Experiments;
use crate::flip::{Flip, Memory};
use crate::outcome::Outcome;

/// Experiments on one emulated board: more of them translate the program less often, fewer lose
/// less if the emulator stops.
const BATCH: usize = 25;

/// Virtual time that a batch cannot exceed, ms.
const LIMIT_MS: u64 = 10_000 + 3_000 * BATCH as u64;

/// The flips with these numbers.
///
/// # Errors
/// The ELF file lacks a symbol.
pub fn draw(
    seed: u64,
    memory: Memory,
    numbers: std::ops::Range<u64>,
) -> Result<Vec<Flip>, FirmwareError> {
    let ranges = memory.ranges(firmware())?;
    Ok(numbers
        .map(|number| Flip::draw(seed, number, memory, &ranges))
        .collect())
}

/// Runs a batch on one emulated board. What the emulator has not judged, since it stopped with an
/// error or its time was over, runs alone, and is told if that does not end either.
fn run_batch(flips: &[Flip]) -> Vec<(Flip, Outcome)> {
    let options = Options {
        keeps_trace: false,
        ..Options::for_ms(LIMIT_MS)
    };
    let finished = run(firmware(), options, Experiments::new(flips.to_vec()));
    let mut results = finished.map_or_else(|_| Vec::new(), |finished| finished.script.results);
    let rest = flips.get(results.len()..).unwrap_or_default();
    match rest {
        [flip] if flips.len() == 1 => results.push((*flip, Outcome::Unjudged)),
        rest => results.extend(rest.iter().flat_map(|flip| run_batch(&[*flip]))),
    }
    results
}

/// Runs these experiments on this number of threads, and reports each batch.
pub fn run_all(
    flips: &[Flip],
    threads: usize,
    report: impl Fn(&[(Flip, Outcome)]) + Sync,
) -> Vec<(Flip, Outcome)> {
    let batches = Mutex::new(flips.chunks(BATCH));
    let results = Mutex::new(Vec::new());
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let next = batches.lock().ok().and_then(|mut batches| batches.next());
                    let Some(batch) = next else { return };
                    let judged = run_batch(batch);
                    report(&judged);
                    if let Ok(mut results) = results.lock() {
                        results.extend(judged);
                    }
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap_or_default();
    results.sort_by_key(|(flip, _)| flip.number);
    results
}
