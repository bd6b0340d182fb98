//! The memory of the second emulator: that of the board's core, and recorded registers.

use virtual_board::processor::{Memory, Processor, Queued, Region};

use super::Shadow;
use crate::registers::{FPCA, Registers, it_of};
use crate::unicorn::{Register, UnicornError};

/// Number of entries of the vector table on this chip.
const VECTOR_COUNT: u32 = 16 + 91;

/// Bank 2 of the flash, which the program has the flash controller write: its reads are recorded
/// like those of a peripheral.
const BANK_2: std::ops::Range<u32> = 0x0810_0000..0x0820_0000;

/// Flash and RAM; the program uses neither the alias of the flash at 0 nor the backup RAM.
const USED: std::ops::Range<u32> = 0x0800_0000..0x4000_0000;

/// Bytes of a page of the board's core.
const PAGE: u32 = 1024;

/// Regions of registers: peripherals with their bit-band alias, and the core's own.
const REGISTERS: [(u32, u32); 4] = [
    (0x4000_0000, 0x0200_0000),
    (0x4200_0000, 0x0200_0000),
    (0x5000_0000, 0x0100_0000),
    (0xe000_0000, 0x0010_0000),
];

impl Shadow {
    /// Maps the memory, and sets the breakpoints at the handlers.
    pub(super) fn prepare(
        &mut self,
        core: &mut dyn Processor,
        memory: &Memory,
    ) -> Result<(), String> {
        let mut regions = Vec::new();
        let is_used = |region: &&Region| USED.contains(&(region.start as u32));
        for region in memory.regions().iter().filter(is_used) {
            let (start, end) = (
                region.start as u32,
                region.start as u32 + region.length as u32,
            );
            if (start..end).contains(&BANK_2.start) {
                regions.push((start, (BANK_2.start - start) as usize));
                regions.push((BANK_2.end, (end - BANK_2.end) as usize));
            } else {
                regions.push((
                    start & !0xfff,
                    (end - (start & !0xfff)).next_multiple_of(4096) as usize,
                ));
            }
        }
        regions.retain(|(_, length)| *length > 0);
        let refused = |error: UnicornError| error.to_string();
        self.second.map_memory(&regions).map_err(refused)?;
        let bank = (BANK_2.start, BANK_2.end - BANK_2.start);
        for (start, length) in REGISTERS.into_iter().chain([bank]) {
            self.second.map_registers(start, length).map_err(refused)?;
        }
        let memory_of_second = self.second.memory().clone();
        self.second.host().memory = memory_of_second;
        for page in BANK_2.step_by(PAGE as usize) {
            core.ask(Queued::Route(page.into()));
        }
        for number in 1..VECTOR_COUNT {
            let mut vector = [0; 4];
            memory.copy(u64::from(self.vectors + 4 * number), &mut vector);
            let handler = u32::from_le_bytes(vector) & !1;
            if number > 1 && handler != 0 && self.handlers.insert(handler) {
                core.add_breakpoint(handler.into());
            }
        }
        self.is_prepared = true;
        Ok(())
    }

    /// Copies all registers and memory of the board.
    pub(super) fn synchronise(&mut self, core: &dyn Processor, memory: &Memory) {
        for region in memory.regions() {
            let mut bytes = vec![0; region.length];
            memory.copy(region.start, &mut bytes);
            let start = region.start as u32;
            // In parts: bank 2 lies in the middle of a region.
            for (part, address) in bytes
                .chunks(PAGE as usize)
                .zip((start..).step_by(PAGE as usize))
            {
                self.second.memory().write(address, part);
            }
        }
        let registers = Registers::of_board(core);
        registers.write(&mut self.second);
        // The emulator would clear all of FPSCR at the first floating-point instruction of each
        // handler, where the processor keeps its flags (DDI 0403E, ExecuteFPCheck).
        self.second
            .write([(Register::CONTROL, registers.masks[3] | FPCA)]);
        self.it = it_of(registers.xpsr);
        self.frames.clear();
        self.returning = None;
        self.is_synchronised = true;
    }

    /// Starts to record the memory that a DMA controller writes.
    pub(super) fn route_streams(&mut self, core: &mut dyn Processor) {
        for &(start, length) in self.streams.watch_new() {
            let end = start + length;
            for page in (start / PAGE..=(end - 1) / PAGE).map(|number| number * PAGE) {
                core.ask(Queued::Route(page.into()));
            }
            if let Err(error) = self.second.watch_memory(start, end) {
                self.difference = Some(error.to_string());
            }
        }
    }
}
