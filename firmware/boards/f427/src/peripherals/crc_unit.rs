//! The CRC calculation unit (RM0090, chapter 4).
//!
//! It computes CRC-32/MPEG-2 of words, most significant bit first.

use core::sync::atomic::{Ordering::SeqCst, compiler_fence};

use firmware::integrity::{ROUND, WordCrc};

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

    #[inline(always)]
    fn add_eight(&self, &[a, b, c, d, e, f, g, h]: &[u32; 8]) {
        self.add(a);
        self.add(b);
        self.add(c);
        self.add(d);
        self.add(e);
        self.add(f);
        self.add(g);
        self.add(h);
        // The next words are not loaded before: there are no more registers.
        compiler_fence(SeqCst);
    }
}

impl WordCrc for CrcUnit {
    fn restart(&mut self) {
        self.0.cr().write(|w| w.reset().reset());
    }

    fn update(&mut self, words: &[u32]) {
        // Eight words at once by a load of several registers, and four times that in a round of the
        // loop, which itself takes as long as four words.
        let (rounds, rest) = words.as_chunks::<{ ROUND }>();
        for round in rounds {
            let (eights, _) = round.as_chunks::<8>();
            let [first, second, third, fourth] = eights else {
                return;
            };
            self.add_eight(first);
            self.add_eight(second);
            self.add_eight(third);
            self.add_eight(fourth);
        }
        for word in rest {
            self.add(*word);
        }
    }

    fn value(&mut self) -> u32 {
        self.0.dr().read().dr().bits()
    }
}
