//! A changed position of a queue between two tasks is a fault.

use board_tests::frames::faults;
use board_tests::program::firmware;
use virtual_board::plant::Bridge;

use crate::disturbed::{DATA_CORRUPT, ENTRIES, Flip, STEP, frames, run};

/// Time of the control step before which a bit is inverted, ms.
const STEP_MS: u64 = 4 * STEP;

/// The positions are checked in the next control period; the bridge brakes from the PWM edge after
/// its control step on, and the message is on the bus.
const BRAKED_MS: u64 = STEP_MS + 8;

/// The processor restarts after a second.
const RESTART_MS: u64 = STEP_MS + 1_000;

/// A bit of the position of the end that writes, and one of the copy of that of the end that reads.
const BITS: [u32; 2] = [0, 27];

const QUEUES: [&str; 8] = [
    "ReceivedFrames",
    "OtherFrames",
    "ProcessData",
    "StepReports",
    "ToSave",
    "SaveResults",
    "UpdateOrders",
    "UpdateResults",
];

/// Addresses of the two positions of a queue, the first words of its memory, which the compiler may
/// have split into variables.
fn positions(queue: &str) -> [u64; 2] {
    let name = format!("queues..{queue}");
    let parts = firmware().variables_containing(&name);
    let mut words: Vec<u64> = parts.flat_map(|part| part.step_by(4)).collect();
    words.sort_unstable();
    [words[0], words[1]]
}

#[test]
fn a_changed_position_of_a_queue_is_told_and_the_motor_brakes_after_two_control_periods() {
    for queue in QUEUES {
        for (address, bit) in positions(queue).into_iter().zip(BITS) {
            let flip = Flip {
                address,
                bit,
                before: "device_control",
                entry: ENTRIES + 1,
            };
            let finished = run(frames, RESTART_MS, Some(flip));
            let faults = faults(&finished);
            let told = faults.first().expect("a message");
            assert_eq!(told.1, DATA_CORRUPT, "{queue}: {faults:?}");
            let told_ms = told.0 / 1_000_000;
            let in_time = STEP_MS..=BRAKED_MS;
            assert!(in_time.contains(&told_ms), "{queue}: {told_ms} ms");

            let braking = BRAKED_MS * 1_000_000..RESTART_MS * 1_000_000;
            let rows = finished.trace.rows.iter();
            let states = rows.filter(|row| braking.contains(&row.at_ns));
            let states: Vec<Bridge> = states.map(|row| row.bridge).collect();
            let count = |state| states.iter().filter(|it| **it == state).count();
            // In the last PWM period of each control period it coasts, for the samples.
            assert_eq!(count(Bridge::Brake) + count(Bridge::Coast), states.len());
            assert!(count(Bridge::Brake) >= states.len() * 7 / 10, "{queue}");
        }
    }
}
