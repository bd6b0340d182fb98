//! Register bits, and the key sequence that unlocks `FLASH_CR` (RM0090, sections 3.6.1 and 3.9).

/// Bits of `FLASH_CR`.
pub(in crate::flash) mod cr {
    pub const PG: u64 = 1;
    pub const SER: u64 = 1 << 1;
    pub const MER: u64 = 1 << 2;
    pub const SNB_SHIFT: u32 = 3;
    pub const PSIZE_SHIFT: u32 = 8;
    pub const MER1: u64 = 1 << 15;
    pub const STRT: u64 = 1 << 16;
    pub const EOPIE: u64 = 1 << 24;
    pub const ERRIE: u64 = 1 << 25;
    pub const LOCK: u64 = 1 << 31;
}

/// Bits of `FLASH_SR`.
pub(in crate::flash) mod sr {
    pub const EOP: u64 = 1;
    pub const OPERR: u64 = 1 << 1;
    pub const WRPERR: u64 = 1 << 4;
    pub const PGAERR: u64 = 1 << 5;
    pub const PGPERR: u64 = 1 << 6;
    pub const PGSERR: u64 = 1 << 7;
    pub const BSY: u64 = 1 << 16;
}

/// Key sequence of `FLASH_CR`.
pub(in crate::flash) const KEYS: [u64; 2] = [0x4567_0123, 0xcdef_89ab];

/// State of the key sequence.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Key {
    entered: usize,
    is_blocked: bool,
}

/// Result of a word of the key sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum KeyProgress {
    /// The sequence is not complete.
    Incomplete,
    /// The register is unlocked.
    Unlocked,
    /// The word was wrong: the register remains locked until the next reset.
    Rejected,
}

impl Key {
    pub fn enter(&mut self, word: u64) -> KeyProgress {
        if self.is_blocked || KEYS.get(self.entered) != Some(&word) {
            self.is_blocked = true;
            return KeyProgress::Rejected;
        }
        self.entered = (self.entered + 1) % KEYS.len();
        if self.entered == 0 {
            KeyProgress::Unlocked
        } else {
            KeyProgress::Incomplete
        }
    }
}
