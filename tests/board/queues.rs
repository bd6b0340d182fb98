//! A changed position of a queue between two tasks is a fault.

use board_tests::frames::faults;
use board_tests::master::{driven, to_and_fro};
use board_tests::program::firmware;
use virtual_board::plant::Bridge;

use crate::disturbed::{DATA_CORRUPT, Flip, run};

/// The control step before which a bit is inverted, while the shaft moves, and its time, ms.
const STEP: u64 = 200;
const STEP_MS: u64 = 4 * STEP;

/// The positions are checked in the next control period; the bridge brakes from the PWM edge after
/// its control step on, and the message is on the bus.
const BRAKED_MS: u64 = STEP_MS + 8;

/// Braking, restart and first message.
const END_MS: u64 = STEP_MS + 1_500;

/// A bit of the position of the end that writes, and one of the copy of that of the end that reads.
const BITS: [u32; 2] = [0, 27];

#[test]
fn a_changed_position_of_a_queue_is_told_and_the_motor_brakes_after_two_control_periods() {
    let queues = [
        "ReceivedFrames",
        "OtherFrames",
        "ProcessData",
        "StepReports",
    ];
    for queue in queues {
        let memory = firmware().symbol_containing(&format!("queues..{queue}"));
        let start = memory.expect("a variable").start;
        for (address, bit) in [start, start + 4].into_iter().zip(BITS) {
            let flip = Flip {
                address,
                bit,
                before: "device_control",
                // Each step but the first one is computed twice.
                entry: 2 * STEP - 2,
            };
            let frames = |tick| driven(tick, to_and_fro(tick));
            let finished = run(frames, END_MS, Some(flip));
            let faults = faults(&finished);
            let first = faults.first().expect("a message");
            assert_eq!(first.1, DATA_CORRUPT, "{queue}: {faults:?}");
            // Without its queue the message is sent after the restart.
            let latest_ms = match queue {
                "OtherFrames" => END_MS,
                _ => BRAKED_MS,
            };
            let told_ms = first.0 / 1_000_000;
            assert!(
                (STEP_MS..=latest_ms).contains(&told_ms),
                "{queue}: {told_ms} ms"
            );
            let braking = BRAKED_MS * 1_000_000..(STEP_MS + 1_000) * 1_000_000;
            // Between the samples of the back-EMF, for which it coasts.
            let rows = finished.trace.rows.iter();
            let mut driven = rows.filter(|row| matches!(row.bridge, Bridge::Driven { .. }));
            let driven = driven.find(|row| braking.contains(&row.at_ns));
            assert!(driven.is_none(), "{queue}: {driven:?}");
        }
    }
}
