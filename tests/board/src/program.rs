//! The board's program and its runs on the emulated board.

use std::sync::OnceLock;

use cross_build::{board_elf, board_h743_elf};
use virtual_board::board::ChipKind;
use virtual_board::run::{Finished, Firmware, Handler, Options, Script, run};

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

/// The program of the board with an STM32H743.
///
/// # Panics
/// If it does not build.
pub fn firmware_h743() -> &'static Firmware {
    static FIRMWARE: OnceLock<Firmware> = OnceLock::new();
    FIRMWARE.get_or_init(|| Firmware::read(board_h743_elf()).expect("an ELF file"))
}

/// Priority of the tasks of the control loop.
pub const LOOP_PRIORITY: u8 = 4;

/// The handlers of the board's program.
///
/// # Panics
/// If it does not list them.
pub fn handlers() -> Vec<Handler> {
    firmware().handlers().expect("a list")
}

/// Registers of the STM32H743 that the emulation only stores: both watchdogs, and the backup
/// register that survives a restart.
const ONLY_STORED: [&str; 4] = [
    "unimplemented IWDG.",
    "unimplemented WWDG.",
    "unimplemented RTC.",
    "unimplemented DBGMCU.",
];

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
    let program = match options.chip {
        ChipKind::F427 => firmware(),
        ChipKind::H743 => firmware_h743(),
    };
    run_program(program, options, script)
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
    let stored: &[&str] = match options.chip {
        ChipKind::F427 => &[],
        ChipKind::H743 => &ONLY_STORED,
    };
    let finished = run(program, options, script).expect("the run succeeds");
    let gaps = finished.gaps.except(stored);
    assert!(gaps.is_empty(), "{gaps}");
    finished
}
