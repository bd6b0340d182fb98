//! The program's own flash: its CRC at the start and in the background.

use core::{
    ptr::addr_of,
    slice,
    sync::atomic::{AtomicBool, Ordering::Relaxed},
};

use firmware::integrity::ProgramCheck;

use crate::peripherals::crc_unit::CrcUnit;

/// Whether the background task has found the flash changed.
static IS_CORRUPT: AtomicBool = AtomicBool::new(false);

/// Whether the program's flash has changed since the start.
pub fn is_corrupt() -> bool {
    IS_CORRUPT.load(Relaxed)
}

/// The check of the program by the chip's CRC unit.
pub type Check = ProgramCheck<'static, CrcUnit>;

/// The program without its last word.
fn program() -> &'static [u32] {
    unsafe extern "C" {
        /// First word of the flash, and the word behind the program (`memory.x`).
        static _program_start: u32;
        static _program_crc: u32;
    }
    let (start, end) = (addr_of!(_program_start), addr_of!(_program_crc));
    let words = (end.addr() - start.addr()) / size_of::<u32>();
    // SAFETY: the flash between the two symbols, both aligned to words, never changes.
    unsafe { slice::from_raw_parts(start, words) }
}

/// CRC of the program, which is written into the file after it is linked.
#[unsafe(link_section = ".program_crc")]
#[unsafe(no_mangle)]
static PROGRAM_CRC: u32 = UNKNOWN;

/// Content of [`PROGRAM_CRC`] without that.
const UNKNOWN: u32 = !0;

/// Checks the program at the start; returns the check for the background, and whether the program
/// is the one that was built.
pub fn start(unit: CrcUnit) -> (Check, bool) {
    // SAFETY: a word of flash. The compiler does not know that it is written after linking.
    let word = unsafe { addr_of!(PROGRAM_CRC).read_volatile() };
    let built = Some(word).filter(|word| *word != UNKNOWN);
    if built.is_none() {
        defmt::warn!("the program has no CRC: changes before this start remain unnoticed");
    }
    ProgramCheck::new(program(), built, unit)
}

/// Checks the next part of the program.
pub fn proceed(check: &mut Check) {
    if !check.proceed() {
        IS_CORRUPT.store(true, Relaxed);
    }
}
