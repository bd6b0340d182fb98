//! What a recording decides is what experiments show, and defects of the recording are found.

mod common;

use std::{ops::Range, sync::LazyLock};

use board_tests::program::firmware;
use common::verdicts;
use fault_campaign::campaign::{Defect, Judged, draw};
use fault_campaign::class::{Class, MemoryMap};
use fault_campaign::injection::{Injection, Place};
use fault_campaign::motion::Motion;
use fault_campaign::outcome::{Basis, Outcome, Verdict};

/// Warm-up of boards on which few experiments are carried out.
const WARM_UP: u64 = 1;

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
    let close = at(device, 0, 15_000).into_iter();
    injections.extend(
        close.filter(|injection| (600..612).contains(&injection.at_ms) && injection.number >= 160),
    );
    let all = verdicts(&injections, WARM_UP, Judged::ByRecording(None));
    let expected = [
        decided(&all, Place::Ram, Outcome::NoEffect, 100),
        decided(&all, Place::Registers, Outcome::NoEffect, 100),
        decided(&all, Place::Ram, Outcome::Told, 20),
        decided(&all, Place::Code, Outcome::Told, 20),
    ]
    .concat();
    let sample: Vec<Injection> = expected.iter().map(|(injection, _)| *injection).collect();
    let found = verdicts(&sample, WARM_UP, Judged::ByExperiments(None));
    for (injection, verdict) in found {
        let (_, expected) = expected.iter().find(|(it, _)| *it == injection).unwrap();
        let times = |verdict: &Verdict| (verdict.outcome, verdict.told_ms, verdict.safe_ms);
        assert_eq!(times(&verdict), times(expected), "{injection:x?}");
    }
}

/// Injections into the RAM during the first motion, at these addresses, with numbers from this one
/// on.
fn at(addresses: Range<u64>, first: u64, count: usize) -> Vec<Injection> {
    let draw = |number| Injection::draw(SEED, number, Place::Ram, std::slice::from_ref(&addresses));
    let drawn = (first..).map(draw);
    let of_motion = drawn.filter(|injection| injection.motion == Motion::Position);
    of_motion.take(count).collect()
}

/// A defect of the recording, and injections that it judges otherwise.
type Case = (Defect, Vec<Injection>);

fn cases() -> [Case; 3] {
    let variable = |name| firmware().symbol_containing(name).expect("a variable");
    let stack_end = firmware().address("_stack_start").expect("a symbol");
    [
        (Defect::NoReads, at(variable("local_init_device"), 0, 40)),
        // The frames of interrupts of the background task.
        (
            Defect::NoFrames,
            at(stack_end - 112..stack_end - 64, 1_000_000, 1500),
        ),
        // What the controller sends to the encoder; the program does not read it.
        (
            Defect::NoTransfers,
            at(variable("encoder4SENT"), 2_000_000, 20),
        ),
    ]
}

/// Verdicts of a recording without and with the defect of a case. One campaign judges the
/// injections of all cases without a defect.
fn compared((defect, injections): &Case) -> Vec<(Verdict, Verdict)> {
    static RIGHT: LazyLock<Vec<(Injection, Verdict)>> = LazyLock::new(|| {
        let all: Vec<_> = cases().into_iter().flat_map(|(_, some)| some).collect();
        verdicts(&all, WARM_UP, Judged::ByRecording(None))
    });
    let wrong = verdicts(injections, WARM_UP, Judged::ByRecording(Some(*defect)));
    let right = |injection| {
        let mut all = RIGHT.iter();
        all.find(|(it, _)| it == injection).expect("it is judged").1
    };
    let both = wrong.iter();
    both.map(|(injection, wrong)| (right(injection), *wrong))
        .collect()
}

#[test]
fn a_recording_without_reads_or_without_the_frames_of_exceptions_gives_other_verdicts() {
    let map = MemoryMap::try_new(firmware()).expect("the symbols exist");
    let [reads, frames, _] = cases();
    for case in [reads, frames] {
        let is_expected = |injection| [Class::Device, Class::Stack].contains(&map.class(injection));
        assert!(case.1.iter().all(is_expected));
        let compared = compared(&case);
        let differ = |(right, wrong): &&(Verdict, Verdict)| right.outcome != wrong.outcome;
        let differing = compared.iter().filter(differ).count();
        println!(
            "{:?}: {differing} of {} verdicts differ",
            case.0,
            compared.len()
        );
        assert!(differing > 0, "{:?}", case.0);
    }
}

#[test]
fn a_flip_in_memory_that_a_dma_controller_reads_is_simulated() {
    let [_, _, transfers] = cases();
    for (right, wrong) in compared(&transfers) {
        assert!(!by_recording(&right) && by_recording(&wrong));
    }
}
