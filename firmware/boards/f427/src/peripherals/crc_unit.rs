//! The CRC calculation unit (RM0090, chapter 4).
//!
//! It computes a CRC with the polynomial of the Ethernet, as CRC-32/ISO-HDLC, but most significant
//! bit first, and neither reflects nor inverts. Words with reversed bits, and a result that is
//! reversed and inverted, give CRC-32/ISO-HDLC of the bytes in memory.

use firmware::integrity::WordCrc;

use crate::chip::pac::CRC;

/// The unit. A word takes four cycles of the AHB.
pub struct CrcUnit(CRC);

impl CrcUnit {
    /// The unit; its clock is enabled.
    pub fn new(registers: CRC) -> Self {
        Self(registers)
    }
}

impl WordCrc for CrcUnit {
    fn restart(&mut self) {
        self.0.cr().write(|w| w.reset().reset());
    }

    fn update(&mut self, words: &[u32]) {
        for word in words {
            self.0.dr().write(|w| w.dr().set(word.reverse_bits()));
        }
    }

    fn value(&mut self) -> u32 {
        !self.0.dr().read().dr().bits().reverse_bits()
    }
}
