//! A sample of the campaign.

use std::sync::{Arc, LazyLock, Mutex};

use board_tests::program::firmware;
use fault_campaign::campaign::{Boards, WARM_UP, draw, draw_each, run_all};
use fault_campaign::injection::{Injection, Place};
use fault_campaign::outcome::{Outcome, Verdict};

/// Seed of another campaign than that of the document.
const SEED: u64 = 2;

/// Share of the injections after which a fault is detected, and the shaft is not at rest in time:
/// more than the rates in `docs/trust.md`.
const RESIDUAL: f64 = 0.02;

/// Silent hazards of the sample, at most. With a rate of 0.015 %, which bounds the rate with a
/// probability of 95 % after none among 20,000, more have a probability of 0.01 % (Poisson
/// distribution with a mean of 0.09).
const SILENT: usize = 2;

/// Injections into each of four places.
const COUNT: u64 = 150;

/// Parts of the names of both copies of the control loop and of its mailboxes.
const PROTECTED: [&str; 3] = ["CONTROL_LOOP", "local_init_messages", "local_init_outputs"];

/// Interval between the sampled bytes of these variables.
const EVERY_BYTE: usize = 64;

fn sample() -> Vec<Injection> {
    let places = [
        Place::Ram,
        Place::Code,
        Place::Registers,
        Place::Instruction,
    ];
    let draw = |place| draw(SEED, place, 0..COUNT).expect("the symbols exist");
    places.into_iter().flat_map(draw).collect()
}

fn protected_bytes() -> Vec<Injection> {
    let names = PROTECTED.iter();
    let variables: Vec<_> = names
        .flat_map(|name| firmware().variables_containing(name))
        .collect();
    let each = draw_each(SEED, &variables).into_iter();
    each.step_by(EVERY_BYTE).collect()
}

/// The verdicts on these injections, all of which one campaign judges: a process that copies itself
/// must have no other thread at work.
fn judged(injections: &[Injection]) -> Vec<(Injection, Verdict)> {
    static ALL: LazyLock<Vec<(Injection, Verdict)>> = LazyLock::new(|| {
        let all = [sample(), protected_bytes()].concat();
        let results = Arc::new(Mutex::new(Vec::new()));
        let kept = results.clone();
        let add = move |injection, verdict| kept.lock().unwrap().push((injection, verdict));
        let boards = Boards {
            processes: 2,
            warm_up: WARM_UP,
        };
        run_all(&all, boards, None, add).expect("the board runs");
        let results = results.lock().unwrap().clone();
        assert_eq!(results.len(), all.len());
        results
    });
    let of_these = ALL.iter().filter(|(it, _)| injections.contains(it));
    of_these.copied().collect()
}

#[test]
fn silent_hazards_of_the_sample_are_not_more_frequent_than_documented() {
    let injections = sample();
    let mut hazardous = judged(&injections);
    assert_eq!(hazardous.len(), injections.len());
    hazardous.retain(|(_, verdict)| verdict.outcome >= Outcome::Coasting);
    assert!(
        hazardous.len() as f64 <= RESIDUAL * injections.len() as f64,
        "{hazardous:x?}"
    );
    hazardous.retain(|(_, verdict)| verdict.outcome >= Outcome::Hazardous);
    println!("{} silent and hazardous: {hazardous:x?}", hazardous.len());
    assert!(hazardous.len() <= SILENT, "{hazardous:x?}");
}

#[test]
fn a_flip_in_a_byte_of_the_loop_or_a_mailbox_is_detected_or_without_effect() {
    let injections = protected_bytes();
    // The loop has 4 KiB.
    assert!(injections.len() >= 64, "{}", injections.len());
    let harmless = [Outcome::NoEffect, Outcome::Detected, Outcome::Restarted];
    let mut others = judged(&injections);
    others.retain(|(_, verdict)| !harmless.contains(&verdict.outcome));
    assert!(others.is_empty(), "{others:x?}");
}
