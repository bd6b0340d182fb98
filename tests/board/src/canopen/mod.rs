//! The program that speaks CANopen, and a master on its bus.

mod frames;
mod master;
mod native;

use std::sync::OnceLock;

use virtual_board::run::{Finished, Firmware, Options, Script, run};

use crate::frames::Frame;
use cross_build::board_elf;

pub use frames::{Seen, control, nmt, read, sdo, seen, start, target, write};
pub use master::{Master, driven};
pub use native::NativeNode;

/// The board's program.
///
/// # Panics
/// If it does not build.
pub fn firmware() -> &'static Firmware {
    static FIRMWARE: OnceLock<Firmware> = OnceLock::new();
    FIRMWARE.get_or_init(|| Firmware::read(board_elf()).expect("an ELF file"))
}

/// Runs what a master sends, and asserts that the emulation had no gap.
///
/// # Panics
/// If it had, or the run does not come about.
pub fn run_master<F>(options: Options, orders: F) -> Finished<Master<F>>
where
    F: Fn(u64) -> Vec<Frame> + Send + 'static,
{
    run_node(options, Master::new(orders))
}

/// The same with a script of its own.
///
/// # Panics
/// As above.
pub fn run_node<S: Script + 'static>(options: Options, script: S) -> Finished<S> {
    let finished = run(firmware(), options, script).expect("it runs");
    assert!(finished.gaps.is_empty(), "{}", finished.gaps);
    finished
}
