//! Check of the program's flash.
//!
//! The board's program checks its own flash in parts, one in each control period. After a mismatch
//! neither code nor data are reliable: the [`Shutdown`](crate::replicated::Shutdown) follows.

use core::mem::replace;

use crc::{CRC_32_MPEG_2, Crc, Digest};

use crate::timing::periods;

/// Control periods in which all of the program's flash is checked once. A change behind the place
/// of the check is found at the end of the next pass: within 0.492 s, less than the 0.5 s after
/// which wrong motion is hazardous (`docs/trust.md`).
pub const PROGRAM_CHECK_PERIODS: u16 = periods(244);

/// Words that a computation takes at once: a part of the program has a multiple of it.
pub const ROUND: usize = 32;

/// The CRC of the STM32's CRC unit (RM0090, chapter 4) in software, by a table of 1 KiB: bit by bit
/// the check of the whole program every 244 ms would take 8 % of the STM32H743's processor.
static SOFTWARE_CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_MPEG_2);

/// CRC of a program: of its words, each with the most significant byte first, as the CRC unit of
/// the chip takes them.
///
/// ```
/// // CRC-32/MPEG-2 of "12345678".
/// let words = [u32::from_be_bytes(*b"1234"), u32::from_be_bytes(*b"5678")];
/// assert_eq!(firmware::integrity::program_crc(&words), 0x49e3_c2fb);
/// ```
pub fn program_crc(program: &[u32]) -> u32 {
    let mut crc = SoftwareCrc::default();
    crc.update(program);
    crc.value()
}

/// Computes the CRC of a program word by word, in software or by a unit of the chip.
pub trait WordCrc {
    /// Starts a computation.
    fn restart(&mut self);
    /// Continues the computation with words.
    fn update(&mut self, words: &[u32]);
    /// The result, as [`program_crc`] of all words since the start.
    fn value(&mut self) -> u32;
}

/// [`WordCrc`] in software, for chips without a unit and for tests.
pub struct SoftwareCrc(Digest<'static, u32>);

impl SoftwareCrc {
    fn digest() -> Digest<'static, u32> {
        SOFTWARE_CRC.digest()
    }
}

impl Default for SoftwareCrc {
    fn default() -> Self {
        Self(Self::digest())
    }
}

impl WordCrc for SoftwareCrc {
    fn restart(&mut self) {
        self.0 = Self::digest();
    }

    fn update(&mut self, words: &[u32]) {
        for word in words {
            self.0.update(&word.to_be_bytes());
        }
    }

    fn value(&mut self) -> u32 {
        replace(&mut self.0, Self::digest()).finalize()
    }
}

/// Checks a program in parts, again and again.
pub struct ProgramCheck<'a, C> {
    program: &'a [u32],
    reference: u32,
    rest: &'a [u32],
    crc: C,
}

impl<'a, C: WordCrc> ProgramCheck<'a, C> {
    /// A check of this program. `built` is the CRC that the program had when it was built, `None`
    /// if that is not known: the reference is then its present CRC.
    pub fn new(program: &'a [u32], built: Option<u32>, mut crc: C) -> (Self, bool) {
        crc.restart();
        crc.update(program);
        let found = crc.value();
        crc.restart();
        let reference = built.unwrap_or(found);
        let check = Self {
            program,
            reference,
            rest: program,
            crc,
        };
        (check, found == reference)
    }

    /// Checks the next part; to be called once in each control period. Returns whether all is well
    /// so far.
    ///
    /// ```
    /// use firmware::integrity::{PROGRAM_CHECK_PERIODS, ProgramCheck, SoftwareCrc};
    ///
    /// let program = [7; 1000];
    /// let (mut check, is_as_built) = ProgramCheck::new(&program, Some(1), SoftwareCrc::default());
    /// assert!(!is_as_built);
    /// let failed = (1..).find(|_| !check.proceed());
    /// assert!(failed <= Some(PROGRAM_CHECK_PERIODS));
    /// ```
    pub fn proceed(&mut self) -> bool {
        let part = self
            .program
            .len()
            .div_ceil(usize::from(PROGRAM_CHECK_PERIODS))
            .next_multiple_of(ROUND);
        let (now, rest) = self.rest.split_at(part.min(self.rest.len()));
        self.crc.update(now);
        self.rest = rest;
        if !rest.is_empty() {
            return true;
        }
        self.rest = self.program;
        let found = self.crc.value();
        self.crc.restart();
        found == self.reference
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::vec::Vec;

    use super::*;

    #[test]
    fn a_flipped_bit_anywhere_is_found_within_one_pass() {
        let program: Vec<u32> = (0..249_u32)
            .map(|at| at.wrapping_mul(0x9e37_79b9))
            .collect();
        let check = |program| ProgramCheck::new(program, None, SoftwareCrc::default()).0;
        let mut good = check(&program);
        assert!((0..3 * PROGRAM_CHECK_PERIODS).all(|_| good.proceed()));
        for at in 0..program.len() {
            let mut flipped = program.clone();
            flipped[at] ^= 1 << (at % 32);
            let mut check = ProgramCheck {
                program: &flipped,
                rest: &flipped,
                ..check(&program)
            };
            assert!(
                (0..PROGRAM_CHECK_PERIODS).any(|_| !check.proceed()),
                "word {at}"
            );
        }
    }
}
