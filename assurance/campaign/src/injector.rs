//! Injections into the core: a bit of a register, or an instruction that is skipped.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use virtual_board::processor::{
    BusLayer, CoreBus, Exit, Layered, Memory, Observer, Processor, RegisterWrite, VirtualNanos,
};

use crate::injection::{Injection, Place};

/// Numbers of the program counter and the program status among the registers.
const PC: usize = 15;
const STATUS: usize = 16;

/// Flags of the program status, N, Z, C, V and Q: the highest five bits.
const FIRST_FLAG: u32 = 27;

/// ITSTATE in the program status (DDI 0403E, B1.4.2).
const IT_BITS: u32 = 0x0600_fc00;

/// What is to be injected, and the number of instructions until then.
type Pending = Option<(u64, Injection)>;

#[derive(Debug, Default)]
struct Work {
    pending: Pending,
    writes: Vec<RegisterWrite>,
    /// The program counter at the injection.
    pc: u32,
}

/// An observer of the core that carries out the injection for which it was armed.
#[derive(Debug, Clone, Default)]
pub struct Injector(Arc<Mutex<Work>>);

impl Injector {
    /// Carries this injection out, so many instructions from now on as it says.
    pub fn arm(&self, injection: Injection) {
        self.work().pending = Some((injection.instructions.into(), injection));
    }

    /// The program counter at the injection; 0 before.
    pub fn pc(&self) -> u32 {
        self.work().pc
    }

    fn work(&self) -> MutexGuard<'_, Work> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Observer for Injector {
    fn run(
        &mut self,
        core: &mut dyn Processor,
        memory: &Memory,
        budget: u32,
        bus: &mut dyn CoreBus,
    ) -> (Exit, u64) {
        let mut work = self.work();
        let Some((left, injection)) = work.pending else {
            return core.run(budget, bus);
        };
        let until = core.retired() + left;
        let (mut exit, mut executed) = (Exit::Budget, 0);
        if left > 0 {
            let first = u64::from(budget).min(left) as u32;
            (exit, executed) = core.run(first, &mut Layered(Limited { inner: bus, until }));
        }
        work.pending = (executed < left).then(|| (left - executed, injection));
        if work.pending.is_none() {
            work.pc = read(core, PC);
            work.writes = inject(core, memory, injection);
        }
        (exit, executed)
    }

    fn take_register_writes(&mut self) -> Vec<RegisterWrite> {
        std::mem::take(&mut self.work().writes)
    }

    fn after_reset(&mut self) {}
}

/// The writes that inject between two instructions.
fn inject(core: &dyn Processor, memory: &Memory, injection: Injection) -> Vec<RegisterWrite> {
    match injection.place {
        Place::Instruction => skip(core, memory),
        _ => {
            let bit = 8 * (injection.address % 4) as u32 + u32::from(injection.bit);
            vec![flip((injection.address / 4) as usize, bit, core)]
        }
    }
}

fn flip(register: usize, bit: u32, core: &dyn Processor) -> RegisterWrite {
    let mask = match register {
        STATUS => 1 << (FIRST_FLAG + bit % (u32::BITS - FIRST_FLAG)),
        // The lowest bit of the program counter does not exist.
        PC => 1 << bit.max(1),
        _ => 1 << bit,
    };
    (register, read(core, register) ^ mask)
}

/// Skips the next instruction, and with it its place in the block of an IT instruction.
fn skip(core: &dyn Processor, memory: &Memory) -> Vec<RegisterWrite> {
    let pc = read(core, PC);
    let mut half = [0; 2];
    memory.copy(pc.into(), &mut half);
    // Five highest bits above 0b11100 begin an instruction of four bytes (DDI 0403E, A5.1).
    let is_wide = u16::from_le_bytes(half) >> 11 > 0b11100;
    let next = pc + if is_wide { 4 } else { 2 };
    let status = read(core, STATUS);
    let after = with_it(status, advanced(it_of(status)));
    vec![(PC, next), (STATUS, after)]
}

/// A register of the core.
fn read(core: &dyn Processor, register: usize) -> u32 {
    let bytes = core.gdb_register(register).unwrap_or_default();
    u32::from_le_bytes(bytes.try_into().unwrap_or_default())
}

/// ITSTATE of a program status.
fn it_of(status: u32) -> u32 {
    status >> 25 & 0b11 | (status >> 10 & 0x3f) << 2
}

fn with_it(status: u32, it: u32) -> u32 {
    status & !IT_BITS | (it & 0b11) << 25 | (it >> 2) << 10
}

/// ITSTATE after an instruction of the block (DDI 0403E, ITAdvance).
fn advanced(it: u32) -> u32 {
    if it & 0b111 == 0 {
        0
    } else {
        it & 0xe0 | it << 1 & 0x1f
    }
}

/// A bus whose run ends at this number of retired instructions.
struct Limited<'a> {
    inner: &'a mut dyn CoreBus,
    until: u64,
}

impl BusLayer for Limited<'_> {
    fn behind(&self) -> &dyn CoreBus {
        self.inner
    }

    fn behind_mut(&mut self) -> &mut dyn CoreBus {
        self.inner
    }

    fn carry_on(&mut self, instructions: u64, event: Option<VirtualNanos>) -> Option<u32> {
        let more = self.inner.carry_on(instructions, event)?;
        let left = self.until.checked_sub(instructions)?;
        (left > 0).then_some(u64::from(more).min(left) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // ITTEE EQ is 0b0000 with the mask 0b0111 (DDI 0403E, A7.3.3): four instructions.
    #[test]
    fn a_skipped_instruction_counts_in_its_block() {
        let mut status = with_it(0xf800_01ff, 0b0000_0111);
        for expected in [0b0000_1110, 0b0001_1100, 0b0001_1000, 0] {
            status = with_it(status, advanced(it_of(status)));
            assert_eq!(it_of(status), expected);
            assert_eq!(status & !IT_BITS, 0xf800_01ff);
        }
    }
}
