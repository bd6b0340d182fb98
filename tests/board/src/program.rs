//! The board's program and its runs on the emulated board.

use std::sync::OnceLock;

use cross_build::board_elf;
use virtual_board::run::{Finished, Firmware, Options, Script, run};

use crate::frames::Frame;
use crate::master::Master;

/// The board's program.
///
/// # Panics
/// If it does not build.
pub fn firmware() -> &'static Firmware {
    static FIRMWARE: OnceLock<Firmware> = OnceLock::new();
    FIRMWARE.get_or_init(|| Firmware::read(board_elf()).expect("an ELF file"))
}

/// Runs the board with a master that sends these frames in each control period, and asserts that
/// the emulation had no gap.
///
/// # Panics
/// If it had one, or the run fails.
pub fn run_master<F>(options: Options, frames: F) -> Finished<Master<F>>
where
    F: Fn(u64) -> Vec<Frame> + Send + 'static,
{
    run_script(options, Master::new(frames))
}

/// Runs the board with this script, and asserts that the emulation had no gap.
///
/// # Panics
/// If it had one, or the run fails.
pub fn run_script<S: Script + 'static>(options: Options, script: S) -> Finished<S> {
    run_program(firmware(), options, script)
}

/// Runs a program with this script, and asserts that the emulation had no gap.
///
/// # Panics
/// If it had one, or the run fails.
pub fn run_program<S: Script + 'static>(
    program: &Firmware,
    options: Options,
    script: S,
) -> Finished<S> {
    let finished = run(program, options, script).expect("the run succeeds");
    assert!(finished.gaps.is_empty(), "{}", finished.gaps);
    finished
}
