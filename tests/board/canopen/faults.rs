//! The same faults on CANopen: each is an EMCY message, and safe within the same times.

use board_tests::canopen::{control, driven, run_master, seen};
use board_tests::frames::Frame;

use crate::faults::{Course, provoke_all};

/// EMCY of the node.
const EMERGENCY: u32 = 0x081;

/// The drive's own faults have instances from here on: their numbers.
const OF_THE_DRIVE: u8 = 0x80;

/// What a master sends instead of this plain frame.
fn order(tick: u64, plain: Option<Frame>) -> Vec<Frame> {
    match plain.map(|frame| frame.bytes()) {
        Some([a, b, c, d, ..]) if tick >= 40 => {
            vec![control(0x0f, i32::from_le_bytes([a, b, c, d]))]
        }
        _ if tick < 40 => driven(tick, 0),
        _ => Vec::new(),
    }
}

#[test]
fn every_provoked_fault_is_an_emergency_and_safe_within_its_times() {
    provoke_all(|options, case| {
        let schedule = case.schedule;
        let finished = run_master(options, move |tick| order(tick, schedule(tick)));
        let emergencies = seen(&finished).into_iter();
        let told = emergencies.filter_map(|seen| {
            let [code, class, _, instance, ..] = seen.frame.bytes();
            let is_raised = seen.frame.raw_id() == (EMERGENCY, false) && (code, class) != (0, 0);
            let number = instance.checked_sub(OF_THE_DRIVE)?;
            is_raised.then_some((seen.at_ns, number))
        });
        Course::of(&finished, told.collect())
    });
}
