//! Bits that flip in the memory of the loop or of a mailbox are detected, or have no effect.

use std::ops::Range;

use board_tests::flips::in_first_copy;
use board_tests::frames::{faults, statuswords};
use board_tests::program::{firmware, run_master};
use firmware::timing::periods;
use virtual_board::faults::{Fault, MemoryLocation, Planned, Trigger};
use virtual_board::plant::Bridge;
use virtual_board::run::Options;
use virtual_board::trace::Row;

use crate::disturbed::{DATA_CORRUPT, DURATION_MS, Flip, STEP, frames, is_detected, motion, run};

/// Bytes between two flips in the memory of the loop, and in that of the mailboxes: primes, so that
/// they meet every kind of field.
const STRIDES: [usize; 2] = [211, 61];

/// The number of flips in a range of memory, before this entry of a function, and how many of them
/// are detected. Those that are not must have no effect.
fn detected(memory: Range<u64>, stride: usize, before: &'static str, entry: u64) -> (usize, usize) {
    let undisturbed = motion(&run(frames, DURATION_MS, None));
    let flips: Vec<bool> = memory
        .step_by(stride)
        .map(|byte| {
            let flip = Flip {
                address: byte & !3,
                bit: (8 * (byte % 4) + byte / 4 % 8) as u32,
                before,
                entry,
            };
            is_detected(&run(frames, DURATION_MS, Some(flip)), &undisturbed)
        })
        .collect();
    let found = flips.iter().filter(|is_detected| **is_detected).count();
    println!("before {before}: {found} of {} detected", flips.len());
    (flips.len(), found)
}

/// The static memory of a name.
fn variable(name: &str) -> Range<u64> {
    firmware().symbol_containing(name).expect("a variable")
}

#[test]
fn a_flip_in_the_memory_of_the_loop_is_detected_or_without_effect() {
    for before in ["first_copy", "second_copy"] {
        let (flips, found) = detected(variable("CONTROL_LOOP"), STRIDES[0], before, STEP);
        // Of the copies only the state is compared, and a part of it is unused, such as an
        // excitation.
        assert!(found > 0, "{found} of {flips}");
    }
}

#[test]
fn a_flip_in_a_posted_message_is_detected_or_without_effect() {
    // The loop verifies the commands in every control period, and other messages when they are new.
    let (_, found) = detected(
        variable("init_messages"),
        STRIDES[1],
        "finish_sampling",
        STEP,
    );
    assert!(found > 0);
    detected(
        variable("init_outputs"),
        STRIDES[1],
        "process_frames",
        2 * STEP,
    );
}

#[test]
fn process_data_stay_away_20_ms_after_the_last_valid_outputs_of_the_loop_and_return() {
    // Entries of the communication, two in a control period: 80 ms.
    let [from, number] = [800, 80].map(|ms| 2 * u64::from(periods(ms)));
    let outputs = variable("init_outputs");
    let half = (outputs.end - outputs.start) / 2;
    // One of the two memories for outputs is the mailbox, the other the reader's.
    let places = [half / 2, half + half / 2].map(|offset| (outputs.start + offset) & !3);
    let flips = (from..from + number).flat_map(|hit| {
        places.map(|address| Planned {
            trigger: Trigger::Symbol {
                name: "UART7".into(),
                hit,
            },
            for_ns: None,
            fault: Fault::FlipRam {
                place: MemoryLocation::Address(address),
                bit: 0,
            },
        })
    });
    let options = Options {
        faults: flips.collect(),
        ..Options::for_ms(DURATION_MS + 200)
    };
    let finished = run_master(options, frames);
    assert_eq!(faults(&finished), []);
    let times_ns: Vec<u64> = statuswords(&finished).iter().map(|it| it.0).collect();
    let gaps = times_ns.windows(2).map(|pair| pair[1] - pair[0]);
    let gaps_ms: Vec<u64> = gaps
        .map(|gap| gap / 1_000_000)
        .filter(|ms| *ms > 25)
        .collect();
    // Of the 80 ms of the flips all but the first 20, and the interval of the process data.
    assert!(matches!(gaps_ms[..], [60..=68]), "{gaps_ms:?}");
}

#[test]
fn a_difference_brakes_the_motor_before_the_output_of_the_first_copy_acts() {
    let (address, bit) = in_first_copy();
    let flip = Flip {
        address,
        bit,
        before: "second_copy",
        entry: STEP,
    };
    let finished = run(frames, DURATION_MS, Some(flip));
    let faults = faults(&finished);
    let (at_ns, fault) = *faults.first().expect("a message");
    assert_eq!(fault, DATA_CORRUPT);
    // The EMCY message follows in the communication cycle at the edge from which the motor brakes.
    let rows = &finished.trace.rows;
    let edges_ns = rows.iter().map(|row| row.at_ns);
    let last_edge_ns = edges_ns.filter(|edge_ns| *edge_ns < at_ns).max();
    let is_driven = |row: &&Row| matches!(row.bridge, Bridge::Driven { .. });
    let last_driven = rows.iter().rev().find(is_driven).expect("it was driven");
    // A row has the state up to its edge.
    assert_eq!(Some(last_driven.at_ns), last_edge_ns);
}
