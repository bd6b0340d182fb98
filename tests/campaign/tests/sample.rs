//! A sample of the campaign.

use board_tests::program::firmware;
use fault_campaign::campaign::{draw, run_all};
use fault_campaign::flip::{Flip, Memory};
use fault_campaign::outcome::Outcome;

/// Flips of each kind, of another seed than that of the document.
const FLIPS: u64 = 25;
const SEED: u64 = 2;

#[test]
fn no_flip_of_the_sample_is_silent_and_hazardous() {
    for memory in [Memory::Ram, Memory::Code] {
        let flips = draw(SEED, memory, 0..FLIPS).expect("the symbols exist");
        let results = run_all(&flips, 2, |_| ());
        assert_eq!(results.len(), flips.len());
        let hazardous = |(_, outcome): &&(Flip, Outcome)| *outcome >= Outcome::Hazardous;
        let hazardous: Vec<_> = results.iter().filter(hazardous).collect();
        assert!(hazardous.is_empty(), "{hazardous:x?}");
    }
}

#[test]
fn every_flip_in_the_canopen_device_is_told() {
    let device = firmware()
        .symbol_containing("init_device")
        .expect("a variable");
    let flips: Vec<Flip> = (0..FLIPS)
        .map(|number| Flip::draw(SEED, number, Memory::Ram, std::slice::from_ref(&device)))
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
