//! Comparison of registers and memory.

use std::collections::BTreeMap;

use virtual_board::processor::Memory;

use super::Shadow;
use crate::registers::{FPCA, Registers, with_it};

/// What was compared.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct Compared {
    /// Executed instructions.
    pub instructions: u64,
    /// Comparisons of all registers.
    pub registers: u64,
    /// Comparisons of all writable memory.
    pub memories: u64,
    /// Bytes of memory in all of them.
    pub bytes: u64,
    /// Stretches that were not compared, as the second emulator did not stop at their end.
    pub unstopped: u64,
    /// Ended handlers by the number of their exception.
    pub handlers: BTreeMap<u32, u64>,
}

impl Shadow {
    pub(super) fn compare(&mut self, board: &Registers, memory: &Memory) -> Result<(), String> {
        let mut found = Registers::of_second(&self.second);
        found.xpsr = with_it(found.xpsr, self.it);
        found.masks[3] = found.masks[3] & !FPCA | board.masks[3] & FPCA;
        self.compared.registers += 1;
        if let Some(difference) = found.difference(board) {
            return Err(format!("at {:08x}: {difference}", board.core[15]));
        }
        if let Some(event) = self.second.host().log.front() {
            return Err(format!("the board makes another access: {event:x?}"));
        }
        if std::mem::take(&mut self.handler_ended) {
            self.compare_memory(memory)?;
        }
        Ok(())
    }

    pub(super) fn compare_memory(&mut self, memory: &Memory) -> Result<(), String> {
        let second = &self.second;
        for &(start, length) in self.streams.ranges() {
            let mut bytes = vec![0; length as usize];
            memory.copy(start.into(), &mut bytes);
            second.memory().write(start, &bytes);
        }
        self.compared.memories += 1;
        for region in memory.regions().iter().filter(|region| region.is_writable) {
            let start = region.start as u32;
            let compare = |bytes: &mut [u8]| memory.first_difference(region.start, bytes);
            if let Some(Some(offset)) = second.memory().with(start, compare) {
                return Err(format!(
                    "the memory at {:08x} differs",
                    start as usize + offset
                ));
            }
            self.compared.bytes += region.length as u64;
        }
        Ok(())
    }
}
