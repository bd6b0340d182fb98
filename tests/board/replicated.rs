//! Bits that flip in the memory of the loop or of a mailbox are detected, or have no effect.

use board_tests::frames::faults;
use board_tests::program::firmware;
use virtual_board::plant::Bridge;

use crate::disturbed::{DATA_CORRUPT, DURATION_MS, Flip, STEP, frames, is_detected, motion, run};

/// Flips in each range of memory: one that is relatively prime to all sizes of fields.
const STRIDE: usize = 97;

/// Whether each flip in a range of memory, before this function in a control period, is detected.
/// Those that are not must have no effect.
fn detected(memory: std::ops::Range<u64>, before: &'static str, entry: u64) -> Vec<(u64, bool)> {
    let undisturbed = motion(&run(frames, DURATION_MS, None));
    let flips = memory.step_by(STRIDE).map(|byte| {
        let flip = Flip {
            address: byte & !3,
            bit: (8 * (byte % 4) + byte / 4 % 8) as u32,
            before,
            entry,
        };
        (
            byte,
            is_detected(&run(frames, DURATION_MS, Some(flip)), &undisturbed),
        )
    });
    flips.collect()
}

/// The static memory of a name.
fn variable(name: &str) -> std::ops::Range<u64> {
    firmware().symbol_containing(name).expect("a variable")
}

#[test]
fn a_flip_in_the_memory_of_the_loop_is_detected_or_without_effect() {
    for before in ["first_copy", "second_copy"] {
        let found = detected(variable("CONTROL_LOOP"), before, STEP);
        let count = found.iter().filter(|(_, is_detected)| *is_detected).count();
        println!("before {before}: {count} of {} detected", found.len());
        // Half of the memory is the copies, the rest is unused.
        assert!(count > found.len() / 4, "{found:?}");
    }
}

#[test]
fn a_flip_in_a_posted_or_a_new_message_is_detected_or_without_effect() {
    for name in ["messages", "outputs"] {
        let found = detected(
            variable(&format!("init_{name}")),
            "process_frames",
            2 * STEP,
        );
        let count = found.iter().filter(|(_, is_detected)| *is_detected).count();
        println!("{name}: {count} of {} detected", found.len());
        // The loop reads the commands in every control period.
        assert!(name != "messages" || count > 0, "{found:?}");
    }
}

#[test]
fn a_difference_brakes_the_motor_before_the_output_of_the_first_copy_acts() {
    let address = variable("CONTROL_LOOP").start + 256;
    let flip = Flip {
        address,
        bit: 3,
        before: "second_copy",
        entry: STEP,
    };
    let finished = run(frames, DURATION_MS, Some(flip));
    let faults = faults(&finished);
    let (at_ns, fault) = *faults.first().expect("a message");
    assert_eq!(fault, DATA_CORRUPT);
    let edges = finished.trace.rows.iter().map(|row| row.at_ns);
    let last_edge = edges.filter(|edge_ns| *edge_ns < at_ns).last();
    // The EMCY message follows in the communication cycle at the edge from which the motor brakes.
    let braked = |row: &&virtual_board::trace::Row| row.bridge == Bridge::Brake;
    let first_braked = finished.trace.rows.iter().find(braked).expect("it brakes");
    let edge_ns = last_edge.expect("an edge before the message");
    assert!(
        first_braked.at_ns <= edge_ns,
        "{} {edge_ns}",
        first_braked.at_ns
    );
}
