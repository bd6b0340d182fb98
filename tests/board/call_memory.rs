//! What a call for the bus or a control step does not access does not change unnoticed while the
//! device is in use.

use board_tests::frames::faults;

use crate::disturbed::{DATA_CORRUPT, DURATION_MS, ENTRIES, Flip, STEP, frames, run};
use crate::repeated_step::{changing_words, device_words};

/// Words of application and axis that each control step changes, at least.
const WORDS: usize = 12;

/// A function and the number of its entry.
type Entry = (&'static str, u64);

/// The calls of a control period.
const CALLS: [Entry; 2] = [("communicate", 2 * STEP), ("communicate", 2 * STEP + 1)];

/// The second computation of a control step.
const SECOND_COMPUTATION: Entry = ("device_control", ENTRIES + 2);

/// Whether the board tells a flip of this word at this entry.
fn is_told(address: u64, (before, entry): Entry) -> bool {
    let flip = Flip {
        address,
        bit: 5,
        before,
        entry,
    };
    let faults = faults(&run(frames, DURATION_MS, Some(flip)));
    faults.iter().any(|(_, fault)| *fault == DATA_CORRUPT)
}

#[test]
fn a_flip_in_application_or_axis_during_a_call_for_the_bus_is_told() {
    let told: Vec<bool> = (changing_words().iter().enumerate())
        .map(|(number, address)| is_told(*address, CALLS[number % 2]))
        .collect();
    // They are one part of the device: all words of it are told, of the others none.
    let first = told.iter().position(|told| *told).expect("one is told");
    let last = told.iter().rposition(|told| *told).expect("one is told");
    println!("told: {} of {}", last - first + 1, told.len());
    assert!(told[first..=last].iter().all(|told| *told), "{told:?}");
    assert!(last - first >= WORDS, "{told:?}");
}

/// Objects that PDOs map by default, in cyclic and in profile modes.
const MAPPED: [u32; 6] = [0x6040, 0x607A, 0x60FF, 0x6041, 0x6064, 0x606C];

/// Whether a word is a mapping entry of one of them: index, sub-index 0, 16 or 32 bits.
fn is_mapping(word: u32) -> bool {
    MAPPED.contains(&(word >> 16)) && matches!(word & 0xFFFF, 16 | 32)
}

#[test]
fn a_flip_in_the_mapping_of_a_pdo_during_a_call_or_a_second_computation_is_told() {
    let words = device_words().into_iter();
    let mappings =
        words.filter(|(_, [first, rest @ ..])| is_mapping(*first) && *rest == [*first; 2]);
    let mut tested = 0;
    for (number, (address, [entry, ..])) in mappings.enumerate() {
        let name = format!("{entry:08X} at {address:x}");
        assert!(is_told(address, CALLS[number % 2]), "{name}");
        assert!(is_told(address, SECOND_COMPUTATION), "{name}");
        tested += 1;
    }
    assert!(tested >= MAPPED.len(), "{tested} mappings");
}
