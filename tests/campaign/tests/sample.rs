//! A sample of the campaign.

use board_tests::program::firmware;
use fault_campaign::campaign::{draw, run_all};
use fault_campaign::injection::{Injection, Place};
use fault_campaign::outcome::Outcome;

/// Injections of each place, of another seed than that of the document.
const INJECTIONS: u64 = 25;
const SEED: u64 = 2;

#[test]
fn no_injection_of_the_sample_is_silent_and_hazardous() {
    let places = [
        Place::Ram,
        Place::Code,
        Place::Registers,
        Place::Instruction,
    ];
    for place in places {
        let injections = draw(SEED, place, 0..INJECTIONS).expect("the symbols exist");
        let results = run_all(&injections, 2, |_| ());
        assert_eq!(results.len(), injections.len());
        let hazardous = |(_, outcome): &&(Injection, Outcome)| *outcome >= Outcome::Hazardous;
        let hazardous: Vec<_> = results.iter().filter(hazardous).collect();
        assert!(hazardous.is_empty(), "{hazardous:x?}");
    }
}

#[test]
fn every_flip_in_the_canopen_device_is_told() {
    let device = firmware()
        .symbol_containing("init_device")
        .expect("a variable");
    let flips: Vec<Injection> = (0..INJECTIONS)
        .map(|number| Injection::draw(SEED, number, Place::Ram, std::slice::from_ref(&device)))
        .collect();
    let silent: Vec<_> = (run_all(&flips, 2, |_| ()).into_iter())
        .filter(|(_, outcome)| *outcome != Outcome::Told)
        .collect();
    // A flip while the device is in use is not noticed if the use overwrites it. With one flip in
    // twenty so, more than four of 25 have a probability of 0.7 % (binomial distribution).
    assert!(silent.len() <= 4, "{silent:x?}");
    assert!(
        silent
            .iter()
            .all(|(_, outcome)| *outcome < Outcome::Hazardous),
        "{silent:x?}"
    );
}
