//! Runs in which a bit of the RAM is inverted at the entry of a function.

use board_tests::frames::{Frame, faults};
use board_tests::master::{Master, driven, to_and_fro};
use board_tests::program::run_master;
use virtual_board::faults::{Fault, MemoryLocation, Planned, Trigger};
use virtual_board::plant::Bridge;
use virtual_board::run::{Finished, Options};

/// Fault 22, corrupt data.
pub const DATA_CORRUPT: u8 = 22;

/// The control step that is disturbed, while the shaft moves.
pub const STEP: u64 = 200;

/// Duration of a run, ms.
pub const DURATION_MS: u64 = 4 * STEP + 200;

/// Commands to and fro.
pub fn frames(tick: u64) -> Vec<Frame> {
    driven(tick, to_and_fro(tick))
}

/// A master that sends frames in each control period.
pub type Driving = Master<fn(u64) -> Vec<Frame>>;

/// An inverted bit.
#[derive(Debug, Clone, Copy)]
pub struct Flip {
    /// Address of the word.
    pub address: u64,
    /// Number of the bit.
    pub bit: u32,
    /// The function before which it is inverted.
    pub before: &'static str,
    /// The entry of the function, counted from 1.
    pub entry: u64,
}

/// Runs with this flip.
pub fn run(
    frames: fn(u64) -> Vec<Frame>,
    duration_ms: u64,
    flip: Option<Flip>,
) -> Finished<Driving> {
    let planned = flip.map(|flip| Planned {
        trigger: Trigger::Symbol {
            name: flip.before.into(),
            hit: flip.entry,
        },
        for_ns: None,
        fault: Fault::FlipRam {
            place: MemoryLocation::Address(flip.address),
            bit: flip.bit,
        },
    });
    let options = Options {
        faults: planned.into_iter().collect(),
        ..Options::for_ms(duration_ms)
    };
    run_master(options, frames)
}

/// Bridge and angle, which do not depend on the number of instructions.
pub fn motion<S>(finished: &Finished<S>) -> Vec<(Bridge, f64)> {
    let rows = finished.trace.rows.iter();
    rows.map(|row| (row.bridge, row.angle_deg)).collect()
}

/// Whether the board has reported corrupt data; otherwise its motion must be the undisturbed one.
pub fn is_detected(disturbed: &Finished<Driving>, undisturbed: &[(Bridge, f64)]) -> bool {
    let codes: Vec<_> = faults(disturbed).iter().map(|(_, code)| *code).collect();
    assert!(
        codes.is_empty() || codes.contains(&DATA_CORRUPT),
        "{codes:?}"
    );
    assert!(!codes.is_empty() || motion(disturbed) == undisturbed);
    !codes.is_empty()
}
