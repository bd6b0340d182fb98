//! Application and axis do not change unnoticed while the device processes the bus.

use board_tests::frames::faults;

use crate::disturbed::{DATA_CORRUPT, DURATION_MS, Flip, STEP, frames, run};
use crate::repeated_step::changing_words;

/// Words of application and axis that each control step changes, at least.
const WORDS: usize = 12;

#[test]
fn a_flip_in_application_or_axis_during_a_call_for_the_bus_is_told() {
    let told: Vec<bool> = (changing_words().iter().enumerate())
        .map(|(number, address)| {
            let flip = Flip {
                address: *address,
                bit: 5,
                before: "communicate",
                // The first or the second call of a control period.
                entry: 2 * STEP + number as u64 % 2,
            };
            let faults = faults(&run(frames, DURATION_MS, Some(flip)));
            faults.iter().any(|(_, fault)| *fault == DATA_CORRUPT)
        })
        .collect();
    // They are one part of the device: all words of it are told, of the others none.
    let first = told.iter().position(|told| *told).expect("one is told");
    let last = told.iter().rposition(|told| *told).expect("one is told");
    println!("told: {} of {}", last - first + 1, told.len());
    assert!(told[first..=last].iter().all(|told| *told), "{told:?}");
    assert!(last - first >= WORDS, "{told:?}");
}
