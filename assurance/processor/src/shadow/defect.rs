//! Defects of the second emulator, to see that they are found.

use super::Shadow;
use crate::unicorn::Register;

/// A defect of the second emulator, to see that it is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Defect {
    /// The carry flag is inverted at the begin of each stretch.
    Carry,
    /// One bit of a byte of the memory is inverted once.
    Memory,
    /// The lowest bit of each read of a peripheral is inverted.
    Read,
}

impl Shadow {
    pub(super) fn make_defect(&mut self) {
        let Some((defect, _)) = self
            .defect
            .filter(|(_, at)| self.compared.instructions >= *at)
        else {
            return;
        };
        match defect {
            Defect::Carry => {
                let [status] = self.second.read([Register::XPSR]);
                self.second.write([(Register::XPSR, status ^ 1 << 29)]);
                return;
            }
            Defect::Memory => {
                // The first variable: the identifier of the log, which nothing writes.
                let at = 0x2000_0000;
                let word = self.second.memory().word(at).unwrap_or(0) ^ 1;
                self.second.memory().write(at, &word.to_le_bytes());
            }
            Defect::Read => {
                let reads = self.log.iter_mut().filter(|event| !event.is_write);
                reads.for_each(|event| event.value ^= 1);
                return;
            }
        }
        self.defect = None;
    }
}
