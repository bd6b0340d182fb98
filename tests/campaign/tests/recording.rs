//! What a recording decides is what experiments show, and defects of the recording are found.

mod common;

use board_tests::program::firmware;
use common::verdicts;
use fault_campaign::campaign::{Defect, Judged, draw};
use fault_campaign::class::{Class, MemoryMap};
use fault_campaign::injection::{Injection, Place};
use fault_campaign::motion::Motion;
use fault_campaign::outcome::{Basis, Outcome, Verdict};

/// Seed of other injections than those of the document.
const SEED: u64 = 77;

fn by_recording(verdict: &Verdict) -> bool {
    verdict.basis == Basis::Recording
}

/// So many injections into this place that a recording has decided with this outcome.
fn decided(
    all: &[(Injection, Verdict)],
    place: Place,
    outcome: Outcome,
    count: usize,
) -> Vec<(Injection, Verdict)> {
    let decided = all.iter().filter(|(injection, verdict)| {
        injection.place == place && verdict.outcome == outcome && by_recording(verdict)
    });
    let decided: Vec<_> = decided.take(count).copied().collect();
    assert_eq!(decided.len(), count, "{place:?}: {outcome:?}");
    decided
}

#[test]
fn experiments_confirm_what_a_recording_decides() {
    let counts = [
        (Place::Ram, 160),
        (Place::Code, 80),
        (Place::Registers, 320),
    ];
    let draw = |(place, count)| draw(SEED, place, 0..count).expect("the symbols exist");
    let mut injections: Vec<Injection> = counts.into_iter().flat_map(draw).collect();
    // So close to each other that many are read first by the same pass of the checksum.
    let device = firmware()
        .symbol_containing("local_init_device")
        .expect("a variable");
    let close = at(device, 15_000).into_iter();
    injections.extend(
        close.filter(|injection| (600..612).contains(&injection.at_ms) && injection.number >= 160),
    );
    let all = verdicts(&injections, Judged::ByRecording(None));
    let expected = [
        decided(&all, Place::Ram, Outcome::NoEffect, 100),
        decided(&all, Place::Registers, Outcome::NoEffect, 100),
        decided(&all, Place::Ram, Outcome::Told, 20),
        decided(&all, Place::Code, Outcome::Told, 20),
    ]
    .concat();
    let sample: Vec<Injection> = expected.iter().map(|(injection, _)| *injection).collect();
    let found = verdicts(&sample, Judged::ByExperiments(None));
    for (injection, verdict) in found {
        let (_, expected) = expected.iter().find(|(it, _)| *it == injection).unwrap();
        let times = |verdict: &Verdict| (verdict.outcome, verdict.told_ms, verdict.safe_ms);
        assert_eq!(times(&verdict), times(expected), "{injection:x?}");
    }
}

/// Injections into the RAM during the first motion, at these addresses.
fn at(addresses: std::ops::Range<u64>, count: usize) -> Vec<Injection> {
    let draw = |number| Injection::draw(SEED, number, Place::Ram, std::slice::from_ref(&addresses));
    let drawn = (0..).map(draw);
    let of_motion = drawn.filter(|injection| injection.motion == Motion::Position);
    of_motion.take(count).collect()
}

/// Verdicts with and without a defect of the recording.
fn compared(injections: &[Injection], defect: Defect) -> Vec<(Verdict, Verdict)> {
    let right = verdicts(injections, Judged::ByRecording(None));
    let wrong = verdicts(injections, Judged::ByRecording(Some(defect)));
    let both = right.into_iter().zip(wrong);
    both.map(|((_, right), (_, wrong))| (right, wrong))
        .collect()
}

#[test]
fn a_recording_without_reads_or_without_the_frames_of_exceptions_gives_other_verdicts() {
    let stack_end = firmware().address("_stack_start").expect("a symbol");
    let map = MemoryMap::try_new(firmware()).expect("the symbols exist");
    let device = firmware()
        .symbol_containing("local_init_device")
        .expect("a variable");
    let cases = [
        (Defect::NoReads, at(device, 40)),
        // The frames of interrupts of the background task.
        (Defect::NoFrames, at(stack_end - 112..stack_end - 64, 1500)),
    ];
    for (defect, injections) in cases {
        assert!(
            injections
                .iter()
                .all(|injection| { [Class::Device, Class::Stack].contains(&map.class(injection)) })
        );
        let compared = compared(&injections, defect);
        let differ = |(right, wrong): &&(Verdict, Verdict)| right.outcome != wrong.outcome;
        let differing = compared.iter().filter(differ).count();
        println!(
            "{defect:?}: {differing} of {} verdicts differ",
            compared.len()
        );
        assert!(differing > 0, "{defect:?}");
    }
}

#[test]
fn a_flip_in_memory_that_a_dma_controller_reads_is_simulated() {
    // What the controller sends to the encoder; the program does not read it.
    let sent = firmware()
        .symbol_containing("encoder4SENT")
        .expect("a variable");
    let injections = at(sent, 20);
    for (right, wrong) in compared(&injections, Defect::NoTransfers) {
        assert!(!by_recording(&right) && by_recording(&wrong));
    }
}
