//! The accesses of the core to the memory in which injections are undecided.

use std::collections::BTreeSet;
use std::ops::Range;

use virtual_board::processor::{
    Access, AccessKind, BusLayer, CoreBus, Memory, Processor, Region, VirtualNanos,
};
use virtual_board::run::{Firmware, FirmwareError};

use crate::defuse::{Decision, Undecided, Use};
use crate::injection::Place;
use crate::routes::Routes;
use crate::streams::Streams;

/// DR of the CRC unit (RM0090, section 4.4).
const CRC_DR: u64 = 0x4002_3000;

/// Instructions from the load of a word to its write to the CRC unit, at most: a load, the reversal
/// of its bits and the write. An interrupt between them has more.
const CRC_INSTRUCTIONS: u64 = 3;

/// An access within so many instructions after an injection does not decide it: the emulator
/// injects into the memory at the next instruction.
const MARGIN: u64 = 4;

/// Where the program has what the recording has to know.
#[derive(Debug, Clone)]
pub struct Layout {
    /// What may be disturbed.
    pub disturbed: Vec<Range<u64>>,
    device: Range<u64>,
    copy_of_device: Range<u64>,
    /// The functions that compute the checksum of the device and copy it.
    checksum: Range<u64>,
    copying: Range<u64>,
    /// The first word of which the program computes its CRC.
    program_start: u64,
}

impl Layout {
    /// The layout of this program.
    ///
    /// # Errors
    /// The ELF file lacks a symbol.
    pub fn try_new(firmware: &Firmware) -> Result<Self, FirmwareError> {
        let mut disturbed = Place::Ram.ranges(firmware)?;
        disturbed.extend(Place::Code.ranges(firmware)?);
        Ok(Self {
            disturbed,
            device: firmware.symbol_containing("local_init_device")?,
            copy_of_device: firmware.symbol_containing("copy_of_device")?,
            checksum: firmware.function_containing("Sealed$LT$T$GT$8checksum")?,
            copying: firmware.function_containing("words4copy")?,
            program_start: firmware.address("_program_start")?,
        })
    }
}

/// A defect of the recording, to show that a test finds it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Defect {
    /// Transfers of the DMA controllers are ignored.
    NoTransfers,
    /// Accesses of exceptions to their frames on the stack are ignored.
    NoFrames,
    /// Reads count as writes.
    NoReads,
}

/// The injections into memory, and what decides them.
#[derive(Debug)]
pub struct Accesses {
    layout: Layout,
    undecided: Undecided,
    /// The decision on each injection.
    pub decisions: Vec<Decision>,
    /// Those that a check of the device read within the margin.
    uncertain: BTreeSet<u32>,
    /// Retired instructions at each injection into memory, and its address.
    since: Vec<(u64, u64)>,
    routes: Routes,
    page_size: u64,
    /// Passes of the checksum and of the CRC that have begun.
    passes: (u32, u32),
    /// Passes of the checksum after which the device was used before the next one: those that the
    /// program compares. The others begin the protection.
    comparing: BTreeSet<u32>,
    /// Loads whose words go to the CRC unit, and the last load from the flash: its instruction, its
    /// number and its word.
    crc_loads: Vec<u64>,
    last_load: (u64, u64, u64),
    /// The copy of the device was read after the first injection.
    pub is_copy_read: bool,
    has_injection: bool,
    /// Accesses of an exception that begins or ends, so far.
    pub frame_accesses: u64,
    pub streams: Streams,
    pub defect: Option<Defect>,
}

impl Accesses {
    /// No accesses yet, and so many injections, of which none was made.
    pub fn new(layout: Layout, injections: usize, do_checks_decide: bool) -> Self {
        Self {
            undecided: Undecided::new(&layout.disturbed, do_checks_decide),
            layout,
            decisions: vec![Decision::Simulate; injections],
            uncertain: BTreeSet::new(),
            since: vec![(0, 0); injections],
            routes: Routes::default(),
            page_size: 0,
            passes: (0, 0),
            comparing: BTreeSet::new(),
            crc_loads: Vec::new(),
            last_load: (0, 0, 0),
            is_copy_read: false,
            has_injection: false,
            frame_accesses: 0,
            streams: Streams::default(),
            defect: None,
        }
    }

    /// An injection into this byte is made before the next instruction.
    pub fn inject(&mut self, core: &dyn Processor, index: u32, address: u64) {
        if !std::mem::replace(&mut self.has_injection, true) {
            self.page_size = core.page_size();
            // Where passes of the checks begin, and all uses of the device.
            let mut always = vec![self.layout.program_start];
            let device = &self.layout.device;
            always.extend(device.clone().step_by(self.page_size as usize));
            always.push(device.end - 1);
            if !self.undecided.do_checks_decide {
                // Whether the copy of the device is read.
                let copy = &self.layout.copy_of_device;
                always.extend(copy.clone().step_by(self.page_size as usize));
                always.push(copy.end - 1);
            }
            for address in always {
                self.routes.add(address, self.page_size);
            }
        }
        self.since[index as usize] = (core.retired(), address);
        if self.undecided.add(index, address) {
            self.decisions[index as usize] = Decision::NoEffect;
            self.routes.add(address, self.page_size);
        }
    }

    /// Has the core make the accesses that may decide an injection by way of the bus.
    pub fn route(&mut self, core: &mut dyn Processor) {
        self.routes.apply(core);
    }

    /// These bytes are used by the instruction of this number.
    pub fn decide(&mut self, address: u64, bytes: usize, usage: Use, number: u64) {
        if let (Use::Check(pass), true) = (usage, self.layout.device.contains(&address)) {
            for index in self.undecided.note(address, bytes, pass) {
                let (since, _) = self.since[index as usize];
                if number <= since + MARGIN {
                    self.uncertain.insert(index);
                }
            }
            return;
        }
        for (index, decision) in self.undecided.decide(address, bytes, usage) {
            let (since, address) = self.since[index as usize];
            self.routes.remove(address, self.page_size);
            let is_certain = number > since + MARGIN;
            let decision = if is_certain {
                decision
            } else {
                Decision::Simulate
            };
            self.decisions[index as usize] = decision;
        }
    }

    /// The decision on an injection.
    pub fn decision(&self, index: u32) -> Decision {
        match self.undecided.first_pass(index) {
            _ if self.uncertain.contains(&index) => Decision::Simulate,
            Some(pass) if self.comparing.contains(&pass) => Decision::Checked(pass),
            // A pass that begins the protection includes what was injected.
            _ => self.decisions[index as usize],
        }
    }

    fn record(&mut self, access: &Access, answer: u64, from_code: bool) {
        let address = access.address;
        if !from_code {
            self.frame_accesses += 1;
            if self.defect == Some(Defect::NoFrames) {
                return;
            }
        }
        let pc = access.program_counter.filter(|_| from_code).unwrap_or(0);
        let is_copying = self.layout.copying.contains(&pc);
        if self.layout.device.contains(&access.address)
            && !is_copying
            && !self.layout.checksum.contains(&pc)
        {
            self.comparing.insert(self.passes.0);
        }
        let usage = match access.kind {
            AccessKind::Write if is_copying => Use::Restore,
            AccessKind::Write => Use::Write,
            AccessKind::Read if self.defect == Some(Defect::NoReads) => Use::Write,
            AccessKind::Read => self.read(access, answer, from_code),
        };
        let bytes = usize::from(access.width.bits()) / 8;
        self.decide(address, bytes, usage, access.instruction_count);
    }

    /// How a read uses its bytes.
    fn read(&mut self, access: &Access, answer: u64, from_code: bool) -> Use {
        let (address, layout) = (access.address, &self.layout);
        let pc = access.program_counter.filter(|_| from_code).unwrap_or(0);
        if layout.device.contains(&address) {
            if layout.checksum.contains(&pc) {
                self.passes.0 += u32::from(address == layout.device.start);
                return Use::Check(self.passes.0);
            }
            // The checksum of what is copied follows the copying.
            if layout.copying.contains(&pc) {
                return Use::Check(self.passes.0 + 1);
            }
        } else if layout.copy_of_device.contains(&address) {
            self.is_copy_read |= self.has_injection;
        } else if from_code {
            if self.crc_loads.contains(&pc) {
                self.passes.1 += u32::from(address == layout.program_start);
                return Use::Check(self.passes.1);
            }
            self.last_load = (pc, access.instruction_count, answer);
        }
        Use::Read
    }

    /// A write to a peripheral.
    fn written(&mut self, access: &Access) {
        self.streams.written(access.address, access.value);
        let (pc, number, word) = self.last_load;
        let is_close = access.instruction_count - number <= CRC_INSTRUCTIONS;
        let reversed = u64::from((word as u32).reverse_bits());
        if access.address == CRC_DR && is_close && access.value == reversed {
            self.crc_loads.push(pc);
            self.last_load = (0, 0, 0);
        }
    }
}

/// Whether an access is one to plain memory, after which the emulator has nothing to do.
fn is_plain(regions: &[Region], access: &Access) -> bool {
    let contains = |region: &&Region| {
        (region.start..region.start + region.length as u64).contains(&access.address)
    };
    let region = regions.iter().find(contains);
    region.is_some_and(|region| region.is_writable || access.kind == AccessKind::Read)
}

/// A bus that records, and whose run ends at a number of retired instructions.
pub struct Tap<'a> {
    inner: &'a mut dyn CoreBus,
    accesses: &'a mut Accesses,
    memory: &'a Memory,
    /// The end of this run, and that of the run that the emulator wants.
    until: u64,
    end: u64,
    /// The emulator has to do something after this instruction.
    must_return: bool,
}

impl<'a> Tap<'a> {
    /// A bus for a run up to `until`, of one up to `end`.
    pub fn new(
        (inner, memory): (&'a mut dyn CoreBus, &'a Memory),
        accesses: &'a mut Accesses,
        until: u64,
        end: u64,
    ) -> Self {
        Self {
            inner,
            accesses,
            memory,
            until,
            end,
            must_return: false,
        }
    }

    /// Whether the emulator has to do something now, and else the end of its run.
    pub fn finish(self) -> (bool, u64) {
        (self.must_return, self.end)
    }
}

impl BusLayer for Tap<'_> {
    fn behind(&self) -> &dyn CoreBus {
        self.inner
    }

    fn behind_mut(&mut self) -> &mut dyn CoreBus {
        self.inner
    }

    fn access(&mut self, access: Access, from_code: bool) -> Option<u64> {
        let answer = self.inner.access(access, from_code);
        if is_plain(self.memory.regions(), &access) {
            self.accesses
                .record(&access, answer.unwrap_or(0), from_code);
        } else {
            // Until the emulator permits the run to continue.
            self.must_return = true;
            if access.kind == AccessKind::Write {
                self.accesses.written(&access);
            }
        }
        answer
    }

    fn carry_on(&mut self, instructions: u64, event: Option<VirtualNanos>) -> Option<u32> {
        // Asked also after an access to the core's own registers.
        let more = self.inner.carry_on(instructions, event);
        self.must_return = more.is_none();
        self.end = instructions + u64::from(more?);
        let left = self.until.min(self.end).checked_sub(instructions)?;
        (left > 0).then_some(left as u32)
    }
}
