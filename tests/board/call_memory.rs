//! What a call for the bus or a control step does not access does not change unnoticed while the
//! device is in use.

use board_tests::frames::faults;
use board_tests::program::{firmware, run_master};
use virtual_board::run::Options;

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
fn is_told(address: u64, entry: Entry) -> bool {
    is_bit_told(address, 5, entry)
}

/// The same of this bit.
fn is_bit_told(address: u64, bit: u32, (before, entry): Entry) -> bool {
    let flip = Flip {
        address,
        bit,
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

/// The lowest bit of the mode of operation: its word has the controlword in its lower half.
const MODE_BIT: u32 = 16;

/// Address of the word with controlword 15 and mode 8.
fn mode_word() -> u64 {
    let is_mode = |word: &u32| *word & 0xFF_FFFF == 0x08_000F;
    let words = device_words().into_iter();
    let found: Vec<u64> = words
        .filter(|(_, values)| values.iter().all(is_mode))
        .map(|(address, _)| address)
        .collect();
    assert_eq!(found.len(), 1, "{found:x?}");
    found[0]
}

/// The entries of a function in the control period of the flips, in which the master sends process
/// data; the name of the function has these parts.
fn entries_of_a_period(parts: [&str; 2]) -> impl Iterator<Item = Entry> {
    let has_parts = |name: &&str| parts.iter().all(|part| name.contains(part));
    let name = firmware().functions().find(has_parts).expect("a function");
    let options = Options {
        probes: vec![name.to_owned()],
        ..Options::for_ms(4 * (STEP + 2))
    };
    let spans = &run_master(options, frames).spans[name];
    // Without the entry a period before the last one, which may be some instructions later. The
    // next one follows no sooner than a pass of the checksum takes, 11 us.
    let begin_ns = spans[spans.len() - 1].at_ns - 4_000_000 + 5_000;
    let before = spans.partition_point(|span| span.at_ns <= begin_ns);
    (before as u64 + 1..=spans.len() as u64).map(move |entry| (name, entry))
}

#[test]
fn another_mode_after_its_use_in_a_control_step_or_before_a_pass_of_the_checksum_is_told() {
    let address = mode_word();
    // In both computations the law of control follows the use of the mode.
    let laws: Vec<Entry> = entries_of_a_period(["CascadeState", "5close"]).collect();
    assert_eq!(laws.len(), 2);
    // Before a step, in its repetition and after it; at the start and the end of both calls.
    let passes: Vec<Entry> = entries_of_a_period(["6sealed", "8checksum"]).collect();
    assert!(passes.len() >= 3 + 2 * 2, "{}", passes.len());
    for entry in laws.into_iter().chain(passes) {
        assert!(is_bit_told(address, MODE_BIT, entry), "{entry:?}");
    }
}

/// The entries of a part of the sealing: at the end of both calls, before the step that follows and
/// after it; for the commands also after process data.
fn seal_entries(name: &str, number: usize) -> Vec<Entry> {
    let entries: Vec<Entry> = entries_of_a_period(["part_seals", name]).collect();
    assert_eq!(entries.len(), number);
    entries
}

#[test]
fn a_flip_in_application_or_axis_while_they_are_sealed_or_at_the_end_of_a_call_is_told() {
    let control = seal_entries("checksum_of_control", 4);
    let pdos = seal_entries("checksum_of_pdos", 4);
    let ends: Vec<Entry> = entries_of_a_period(["AcceptedIds", "3new"]).collect();
    assert_eq!(ends.len(), 2);
    // A word of them that both computations of a step compare, for the flip after both.
    let address = (changing_words().into_iter())
        .find(|address| is_told(*address, CALLS[0]) && is_told(*address, control[3]))
        .expect("a word that is compared");
    for entry in ends.into_iter().chain(control).chain(pdos) {
        assert!(is_told(address, entry), "{entry:?}");
    }
}

#[test]
fn another_mode_during_a_call_for_the_bus_or_while_it_is_sealed_is_told() {
    let address = mode_word();
    for entry in CALLS
        .into_iter()
        .chain(seal_entries("checksum_of_commands", 4 + 1))
    {
        assert!(is_bit_told(address, MODE_BIT, entry), "{entry:?}");
    }
}
