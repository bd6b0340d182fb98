//! Check of the program's flash, and the fault that a restarted program reports.
//!
//! The board's program checks its own flash in parts, one in each control period, and the memory of
//! the [`Device`](crate::drive::Device) before each use. After a mismatch neither code nor data are
//! reliable: the program brakes, restarts the processor and reports the fault, whose number it
//! keeps in a register that survives the restart.

use crc::{CRC_32_ISO_HDLC, Crc, Digest, NoTable, Table};

use crate::faults::Fault;
use crate::timing::periods;

/// Control periods in which all of the program's flash is checked once. A change behind the place
/// of the check is found at the end of the next pass: within 0.4 s, less than the 0.5 s after which
/// wrong motion is hazardous (`docs/trust.md`).
pub const PROGRAM_CHECK_PERIODS: u16 = periods(200);

/// The CRC of small data, bit by bit: hashing a word takes about 250 instructions at start-up or in
/// a save, outside the control step.
pub(crate) const SMALL_CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// The CRC of the program.
static PROGRAM_CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// CRC of a program.
///
/// ```
/// assert_eq!(firmware::integrity::program_crc(b"123456789"), 0xcbf4_3926);
/// ```
pub fn program_crc(program: &[u8]) -> u32 {
    PROGRAM_CRC.checksum(program)
}

/// Checks a program in parts, again and again.
pub struct ProgramCheck<'a> {
    program: &'a [u8],
    crc: u32,
    rest: &'a [u8],
    digest: Digest<'static, u32, Table<1>>,
}

impl<'a> ProgramCheck<'a> {
    /// A check of this program, which has this CRC.
    pub fn new(program: &'a [u8], crc: u32) -> Self {
        Self {
            program,
            crc,
            rest: program,
            digest: PROGRAM_CRC.digest(),
        }
    }

    /// Checks the next part; to be called once in each control period. Returns whether all is well
    /// so far.
    ///
    /// ```
    /// use firmware::integrity::{PROGRAM_CHECK_PERIODS, ProgramCheck, program_crc};
    ///
    /// let program = [7; 1000];
    /// let mut check = ProgramCheck::new(&program, program_crc(&program) ^ 1);
    /// let failed = (1..).find(|_| !check.proceed());
    /// assert_eq!(failed, Some(PROGRAM_CHECK_PERIODS));
    /// ```
    pub fn proceed(&mut self) -> bool {
        let part = self
            .program
            .len()
            .div_ceil(usize::from(PROGRAM_CHECK_PERIODS));
        let (now, rest) = self.rest.split_at(part.min(self.rest.len()));
        self.digest.update(now);
        self.rest = rest;
        if !rest.is_empty() {
            return true;
        }
        self.rest = self.program;
        core::mem::replace(&mut self.digest, PROGRAM_CRC.digest()).finalize() == self.crc
    }
}

/// Marks a register that holds the fault of a restart: any other content is that of another reset.
const MARK: u32 = 0x5341_0000;

/// Content of the register for a restart because of this fault.
pub const fn restart_mark(fault: Fault) -> u32 {
    MARK | fault.number() as u32
}

/// The fault of a restart by the content of the register.
///
/// ```
/// use firmware::{faults::Fault, integrity::{restart_fault, restart_mark}};
/// assert_eq!(restart_fault(restart_mark(Fault::DataCorrupt)), Some(Fault::DataCorrupt));
/// assert_eq!(restart_fault(0), None);
/// ```
pub fn restart_fault(register: u32) -> Option<Fault> {
    let number = register.wrapping_sub(MARK);
    Fault::of_number(u16::try_from(number).ok()?)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::vec::Vec;

    use super::*;

    #[test]
    fn a_flipped_bit_anywhere_is_found_within_one_pass() {
        let program: Vec<u8> = (0..999_u32).map(|at| (at * 7 % 251) as u8).collect();
        let crc = program_crc(&program);
        let mut good = ProgramCheck::new(&program, crc);
        assert!((0..3 * PROGRAM_CHECK_PERIODS).all(|_| good.proceed()));
        for at in 0..program.len() {
            let mut flipped = program.clone();
            flipped[at] ^= 1 << (at % 8);
            let mut check = ProgramCheck::new(&flipped, crc);
            assert!(
                (0..PROGRAM_CHECK_PERIODS).any(|_| !check.proceed()),
                "byte {at}"
            );
        }
    }
}
