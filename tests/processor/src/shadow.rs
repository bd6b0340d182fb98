//! Runs the second emulator in step with the core of the emulated board, and compares both.
//!
//! The board's core runs a stretch of instructions; then the second emulator runs as many, with the
//! recorded reads, and registers are compared. Each handler of an interrupt has a breakpoint at its
//! entry, so that every exception begins between two stretches: it is taken there on the second
//! emulator as well. When a handler ends, all memory that the program can write is compared.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use virtual_board::processor::{
    CoreBus, Exit, Layered, Memory, Observer, Processor, Queued, Region,
};

use crate::cycles::Cycles;
use crate::frames::Frames;
use crate::registers::{FPCA, Registers, holds, it_of, with_it};
use crate::replay::{Replay, size};
use crate::streams::Streams;
use crate::tap::{Event, Tap};
use crate::unicorn::{Register, Unicorn, UnicornError};

/// Number of entries of the vector table on this chip.
const VECTOR_COUNT: u32 = 16 + 91;

/// Bank 2 of the flash, which the program has the flash controller write: its reads are recorded
/// like those of a peripheral.
const BANK_2: std::ops::Range<u32> = 0x0810_0000..0x0820_0000;

/// Flash and RAM; the program uses neither the alias of the flash at 0 nor the backup RAM.
const USED: std::ops::Range<u32> = 0x0800_0000..0x4000_0000;

/// The RAM.
const RAM: std::ops::Range<u32> = 0x1000_0000..0x4000_0000;

/// Bytes of a page of the board's core.
const PAGE: u32 = 1024;

/// Regions of registers: peripherals with their bit-band alias, and the core's own.
const REGISTERS: [(u32, u32); 4] = [
    (0x4000_0000, 0x0200_0000),
    (0x4200_0000, 0x0200_0000),
    (0x5000_0000, 0x0100_0000),
    (0xe000_0000, 0x0010_0000),
];

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

/// The second emulator, in step with the board's core.
#[derive(Debug)]
pub struct Shadow {
    second: Unicorn<Replay>,
    /// Address of the vector table.
    vectors: u32,
    /// What was compared.
    pub compared: Compared,
    /// What differed first.
    pub difference: Option<String>,
    /// To be made after this number of instructions.
    pub defect: Option<(Defect, u64)>,
    frames: Frames,
    streams: Streams,
    /// ITSTATE of the next instruction.
    it: u8,
    /// EXC_RETURN of a return that has not been restored yet.
    returning: Option<u32>,
    is_synchronised: bool,
    is_prepared: bool,
    handlers: BTreeSet<u32>,
    log: VecDeque<Event>,
    handler_ended: bool,
    accesses: u64,
    /// The second emulator executed more instructions than it was told.
    overran: bool,
    /// Ends the run.
    pub stop: Arc<AtomicBool>,
}

impl Shadow {
    /// A second emulator for a program with its vector table at this address.
    ///
    /// # Errors
    /// The library cannot be used.
    pub fn open(library: &Path, vectors: u32) -> Result<Self, UnicornError> {
        Ok(Self {
            second: Unicorn::open(library, Replay::default())?,
            vectors,
            compared: Compared::default(),
            difference: None,
            defect: None,
            frames: Frames::default(),
            streams: Streams::default(),
            it: 0,
            returning: None,
            is_synchronised: false,
            is_prepared: false,
            handlers: BTreeSet::new(),
            log: VecDeque::new(),
            handler_ended: false,
            accesses: 0,
            overran: false,
            stop: Arc::default(),
        })
    }

    /// Version of the library.
    pub fn version(&self) -> (u32, u32) {
        self.second.version()
    }

    /// The bound of the cycles.
    pub fn cycles(&mut self) -> &Cycles {
        &self.second.host().cycles
    }

    /// Number of compared reads and writes.
    pub fn accesses(&self) -> u64 {
        self.accesses
    }

    /// Maps the memory, and sets the breakpoints at the handlers.
    fn prepare(&mut self, core: &mut dyn Processor, memory: &Memory) -> Result<(), String> {
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
    fn synchronise(&mut self, core: &dyn Processor, memory: &Memory) {
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
        self.second.host().cycles.clear();
        self.returning = None;
        self.is_synchronised = true;
    }

    /// Executes instructions on the second emulator.
    fn execute(&mut self, instructions: u64) -> Result<(), String> {
        self.compared.instructions += instructions;
        let mut left = instructions;
        while left > 0 {
            if let Some(link) = self.returning.take() {
                self.leave(link)?;
            }
            if self.it != 0 {
                self.execute_in_block()?;
                left -= 1;
                continue;
            }
            let executed = self.run(left, None)?;
            left -= executed;
            if self.second.host().before_block {
                let [pc] = self.second.read([Register::core(15)]);
                let half = self.second.memory().half(pc).unwrap_or(0);
                self.it = half as u8;
                self.second.write([(Register::core(15), (pc + 2) | 1)]);
                self.second.host().cycles.skipped(2);
                left -= 1;
            } else if executed == 0 && self.returning.is_none() {
                let [pc] = self.second.read([Register::core(15)]);
                return Err(format!("the second emulator does not execute {pc:08x}"));
            }
        }
        Ok(())
    }

    /// Runs the second emulator; returns the number of executed instructions.
    fn run(&mut self, instructions: u64, end: Option<u32>) -> Result<u64, String> {
        let [pc] = self.second.read([Register::core(15)]);
        self.second.host().begin(instructions);
        let ended = self.second.run(pc, end);
        let host = self.second.host();
        self.accesses = host.accesses;
        let difference = host.difference.take();
        let (executed, returned) = (host.executed, host.returned);
        self.overran |= host.overran;
        if let Some(difference) = difference.filter(|_| !self.overran) {
            return Err(difference);
        }
        ended.map_err(|error| format!("{error} after {pc:08x}"))?;
        if returned {
            // The program jumped to EXC_RETURN, whose lowest bit selects Thumb code.
            let [pc] = self.second.read([Register::core(15)]);
            self.returning = Some(pc | 1);
        }
        Ok(executed)
    }

    /// Executes one instruction within the block of an IT instruction: as the last one of a block
    /// with its condition.
    fn execute_in_block(&mut self) -> Result<(), String> {
        let [status, pc] = self.second.read([Register::XPSR, Register::core(15)]);
        let half = self.second.memory().half(pc).unwrap_or(0);
        let next = pc + size(half);
        if holds(self.it >> 4, status) {
            let alone = self.it & 0xf0 | 0b1000;
            self.second
                .write([(Register::XPSR, with_it(status, alone))]);
            self.run(1, Some(next))?;
        } else {
            self.second.write([(Register::core(15), next | 1)]);
            self.second.host().cycles.skipped(next - pc);
        }
        self.it = if self.it & 0b111 == 0 {
            0
        } else {
            self.it & 0xe0 | self.it << 1 & 0x1f
        };
        Ok(())
    }

    fn leave(&mut self, link: u32) -> Result<(), String> {
        let [status] = self.second.read([Register::XPSR]);
        *self.compared.handlers.entry(status & 0x1ff).or_default() += 1;
        self.handler_ended = true;
        self.second.host().cycles.leave();
        self.it = self.frames.leave(&mut self.second, link)?;
        Ok(())
    }

    /// Takes or returns from an exception where the board's core has.
    fn follow_exceptions(&mut self, board: &Registers) -> Result<(), String> {
        let number = board.exception();
        let vector = self
            .second
            .memory()
            .word(self.vectors + 4 * number)
            .unwrap_or(0);
        let is_at_handler = number != 0 && board.core[15] == vector & !1;
        if let Some(link) = self.returning.take() {
            let [at, status] = self.second.read([Register::core(13), Register::XPSR]);
            if is_at_handler && board.core[13] == at && board.core[14] == link {
                *self.compared.handlers.entry(status & 0x1ff).or_default() += 1;
                self.handler_ended = true;
                let cycles = &mut self.second.host().cycles;
                cycles.leave();
                cycles.enter(number);
                Frames::chain(&mut self.second, link, (number, vector & !1));
                return Ok(());
            }
            self.leave(link)?;
        }
        let [pc, status] = self.second.read([Register::core(15), Register::XPSR]);
        if is_at_handler && (status & 0x1ff != number || pc != board.core[15]) {
            self.frames.enter(
                &mut self.second,
                (number, vector & !1),
                self.it,
                board.core[14],
            )?;
            self.it = 0;
            self.second.host().cycles.enter(number);
        }
        Ok(())
    }

    fn compare(&mut self, board: &Registers, memory: &Memory) -> Result<(), String> {
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

    fn compare_memory(&mut self, memory: &Memory) -> Result<(), String> {
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

    /// Follows a stretch of the board's core.
    fn follow(
        &mut self,
        core: &dyn Processor,
        memory: &Memory,
        instructions: u64,
    ) -> Result<(), String> {
        self.make_defect();
        // In a watched page the board's core reports every access, the second emulator those to the
        // ranges alone.
        let compared =
            |event: &Event| !RAM.contains(&event.address) || self.streams.is_watched(event.address);
        let log = self.log.drain(..).filter(compared);
        self.second.host().log.extend(log);
        let second = &self.second;
        self.frames.store_lazy(second, |address, bytes| {
            memory.first_difference(address.into(), bytes).is_some()
        });
        self.overran = false;
        self.execute(instructions)?;
        let board = Registers::of_board(core);
        if self.overran {
            self.compared.unstopped += 1;
            self.second
                .forget_code()
                .map_err(|error| error.to_string())?;
            self.synchronise(core, memory);
            self.second.host().log.clear();
            return Ok(());
        }
        self.follow_exceptions(&board)?;
        self.compare(&board, memory)
    }

    fn make_defect(&mut self) {
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

    /// Ends the comparison, and the run.
    fn end(&mut self, core: &mut dyn Processor, difference: String) {
        self.difference.get_or_insert(difference);
        for handler in &self.handlers {
            core.remove_breakpoint((*handler).into());
        }
        self.stop.store(true, Relaxed);
    }

    /// Starts to record the memory that a DMA controller writes.
    fn route_streams(&mut self, core: &mut dyn Processor) {
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

impl Observer for Shadow {
    fn run(
        &mut self,
        core: &mut dyn Processor,
        memory: &Memory,
        budget: u32,
        bus: &mut dyn CoreBus,
    ) -> (Exit, u64) {
        if self.difference.is_some() {
            return core.run(budget, bus);
        }
        if !self.is_prepared
            && let Err(difference) = self.prepare(core, memory)
        {
            self.end(core, difference);
            return core.run(budget, bus);
        }
        if !self.is_synchronised {
            self.synchronise(core, memory);
        }
        let start = core.retired();
        let mut end = start + u64::from(budget);
        loop {
            self.route_streams(core);
            let left = (end - core.retired()) as u32;
            let mut tap = Layered(Tap {
                inner: bus,
                log: &mut self.log,
                end: &mut end,
            });
            let (exit, instructions) = core.run(left, &mut tap);
            self.streams.update(&self.log);
            if let Err(difference) = self.follow(core, memory, instructions) {
                self.end(core, difference);
            }
            let handler = core.pc();
            if exit != Exit::Breakpoint || !self.handlers.contains(&(handler as u32)) {
                return (exit, core.retired() - start);
            }
            core.pass_breakpoint(handler);
            if end == core.retired() {
                return (Exit::Budget, core.retired() - start);
            }
        }
    }

    fn after_reset(&mut self) {
        self.is_synchronised = false;
        self.log.clear();
        self.second.host().log.clear();
    }
}
