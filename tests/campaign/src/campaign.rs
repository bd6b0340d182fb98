//! A campaign: many experiments on several threads.

use std::sync::{Arc, Mutex, mpsc};
use std::thread;

use board_tests::program::firmware;
use virtual_board::run::{Attachments, FirmwareError, Options, run_with};

use crate::experiment::Experiments;
use crate::injection::{Injection, Place};
use crate::injector::Injector;
use crate::outcome::Outcome;

/// Experiments on one emulated board: more of them translate the program less often, fewer lose
/// less if the emulator stops.
const BATCH: usize = 50;

/// Virtual time that a batch cannot exceed, ms.
const LIMIT_MS: u64 = 10_000 + 3_000 * BATCH as u64;

/// The injections with these numbers.
///
/// # Errors
/// The ELF file lacks a symbol.
pub fn draw(
    seed: u64,
    place: Place,
    numbers: std::ops::Range<u64>,
) -> Result<Vec<Injection>, FirmwareError> {
    let ranges = place.ranges(firmware())?;
    Ok(numbers
        .map(|number| Injection::draw(seed, number, place, &ranges))
        .collect())
}

/// Runs a batch on one emulated board, and on another one after an injection that ends the emulator
/// with an error or takes all of its time.
fn run_batch(injections: &[Injection]) -> Vec<(Injection, Outcome)> {
    let mut results = Vec::new();
    while results.len() < injections.len() {
        let left = &injections[results.len()..];
        let judged = run_until_it_ends(left);
        let has_judged = !judged.is_empty();
        results.extend(judged);
        if !has_judged {
            results.push((left[0], Outcome::Unjudged));
        }
    }
    results
}

/// Runs these experiments one after the other; returns those that were judged.
fn run_until_it_ends(injections: &[Injection]) -> Vec<(Injection, Outcome)> {
    let options = Options {
        keeps_trace: false,
        ..Options::for_ms(LIMIT_MS)
    };
    let injector = Injector::default();
    let (judged, results) = mpsc::channel();
    let script = Experiments::new(injections.to_vec(), injector.clone(), judged);
    let attachments = Attachments {
        observer: Some(Arc::new(Mutex::new(injector))),
        ..Attachments::default()
    };
    // An error ends the experiment that has not been judged.
    let _ = run_with(firmware(), options, script, attachments);
    results.try_iter().collect()
}

/// Runs these experiments on this number of threads, and reports each batch.
pub fn run_all(
    injections: &[Injection],
    threads: usize,
    report: impl Fn(&[(Injection, Outcome)]) + Sync,
) -> Vec<(Injection, Outcome)> {
    let batches = Mutex::new(injections.chunks(BATCH));
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
    results.sort_by_key(|(injection, _)| injection.number);
    results
}
