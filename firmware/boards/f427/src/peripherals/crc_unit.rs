//! The CRC calculation unit (RM0090, chapter 4).
//!
//! It computes CRC-32/MPEG-2 of words, most significant bit first.

use firmware::integrity::WordCrc;

use crate::chip::pac::CRC;

/// The unit. A word takes four cycles of the AHB.
pub struct CrcUnit(CRC);

impl CrcUnit {
    /// The unit; its clock is enabled.
    pub fn new(registers: CRC) -> Self {
        Self(registers)
    }

    #[inline(always)]
    fn add(&self, word: u32) {
        self.0.dr().write(|w| w.dr().set(word));
    }
}

impl WordCrc for CrcUnit {
    fn restart(&mut self) {
        self.0.cr().write(|w| w.reset().reset());
    }

    fn update(&mut self, words: &[u32]) {
        // Eight words in a round: the loop itself takes as long as four.
        let (rounds, rest) = words.as_chunks::<8>();
        for &[a, b, c, d, e, f, g, h] in rounds {
            self.add(a);
            self.add(b);
            self.add(c);
            self.add(d);
            self.add(e);
            self.add(f);
            self.add(g);
            self.add(h);
        }
        for word in rest {
            self.add(*word);
        }
    }

    fn value(&mut self) -> u32 {
        self.0.dr().read().dr().bits()
    }
}
