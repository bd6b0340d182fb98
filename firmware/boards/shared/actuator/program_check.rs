//! The program's own flash: its CRC at the start and in the background.

use core::{
    ptr::addr_of,
    slice,
    sync::atomic::{AtomicBool, Ordering::Relaxed},
};

use firmware::integrity::{ProgramCheck, program_crc};

/// Whether the background task has found the flash changed.
static IS_CORRUPT: AtomicBool = AtomicBool::new(false);

/// Whether the program's flash has changed since the start.
pub fn is_corrupt() -> bool {
    IS_CORRUPT.load(Relaxed)
}

/// The program without its last word.
fn program() -> &'static [u8] {
    unsafe extern "C" {
        /// First word of the flash, and the word behind the program (`memory.x`).
        static _program_start: u8;
        static _program_crc: u32;
    }
    let (start, end) = (addr_of!(_program_start), addr_of!(_program_crc));
    // SAFETY: the flash between the two symbols is memory that never changes.
    unsafe { slice::from_raw_parts(start, end.addr() - start.addr()) }
}

/// CRC of the program, which is written into the file after it is linked.
#[unsafe(link_section = ".program_crc")]
#[unsafe(no_mangle)]
static PROGRAM_CRC: u32 = UNKNOWN;

/// Content of [`PROGRAM_CRC`] without that.
const UNKNOWN: u32 = !0;

/// Checks the program at the start; returns whether it is the program that was built, and the check
/// for the background.
pub fn start() -> (bool, ProgramCheck<'static>) {
    let program = program();
    let found = program_crc(program);
    // SAFETY: a word of flash. The compiler does not know that it is written after linking.
    let built = unsafe { addr_of!(PROGRAM_CRC).read_volatile() };
    if built == UNKNOWN {
        defmt::warn!("the program has no CRC: changes before this start remain unnoticed");
    }
    let is_as_built = built == UNKNOWN || built == found;
    let reference = if built == UNKNOWN { found } else { built };
    (is_as_built, ProgramCheck::new(program, reference))
}

/// Checks the next part of the program.
pub fn proceed(check: &mut ProgramCheck<'_>) {
    if !check.proceed() {
        IS_CORRUPT.store(true, Relaxed);
    }
}
