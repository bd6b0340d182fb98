//! The registers in which injections are undecided.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use virtual_board::processor::{Memory, Processor};

use crate::defuse::Decision;
use crate::effects::{ALL, C, Decoder, Effects, N, Q, Registers, V, Z};
use crate::injection::Injection;
use crate::injector::{STATUS, flag, it_of, read};

/// Instructions after which an injection is simulated whose register was neither used nor replaced.
const LONGEST: u64 = 5_000;

/// Number of the exception in the program status (DDI 0403E, B1.4.2).
const EXCEPTION: u32 = 0x1ff;

/// An injection whose register is undecided.
#[derive(Debug)]
struct Live {
    index: u32,
    register: Registers,
    since: u64,
}

/// The injections into registers.
#[derive(Debug, Default)]
pub struct Liveness {
    decoder: Decoder,
    /// Those to come: retired instructions until then, index and register.
    coming: BinaryHeap<Reverse<(u64, u32, Registers)>>,
    live: Vec<Live>,
}

/// The core before an instruction.
#[derive(Debug, Clone, Copy)]
pub struct Before {
    pc: u32,
    status: u32,
    frame_accesses: u64,
}

impl Liveness {
    /// An injection after so many retired instructions.
    pub fn add(&mut self, index: u32, injection: &Injection, at: u64) {
        // The program counter is used by each instruction.
        if let Some(register) = register(injection) {
            self.coming.push(Reverse((at, index, register)));
        }
    }

    /// The injections before the next instruction are made.
    pub fn inject(&mut self, retired: u64) {
        while let Some(Reverse((at, ..))) = self.coming.peek()
            && *at <= retired
            && let Some(Reverse((_, index, register))) = self.coming.pop()
        {
            self.live.push(Live {
                index,
                register,
                since: retired,
            });
        }
    }

    /// Number of retired instructions up to which no instruction has to be observed.
    pub fn unobserved_until(&self, retired: u64) -> u64 {
        if self.live.is_empty() {
            let next = self.coming.peek();
            next.map_or(u64::MAX, |Reverse((at, ..))| *at)
        } else {
            retired
        }
    }

    /// The core before an instruction that is to be observed.
    pub fn before(&self, core: &dyn Processor, frame_accesses: u64) -> Option<Before> {
        (!self.live.is_empty()).then(|| Before {
            pc: core.pc() as u32,
            status: read(core, STATUS),
            frame_accesses,
        })
    }

    /// An instruction was executed, or an exception began or ended: reports each decision.
    pub fn observe(
        &mut self,
        core: &dyn Processor,
        memory: &Memory,
        before: Before,
        frame_accesses: u64,
        mut decide: impl FnMut(u32, Decision),
    ) {
        let is_alone = frame_accesses == before.frame_accesses
            && (read(core, STATUS) ^ before.status) & EXCEPTION == 0;
        let effects = if is_alone {
            self.effects(memory, before)
        } else {
            Effects {
                uses: ALL,
                replaces: 0,
            }
        };
        let retired = core.retired();
        self.live.retain(|live| {
            let decision = if effects.uses & live.register != 0 || retired - live.since > LONGEST {
                Some(Decision::Simulate)
            } else if effects.replaces & live.register != 0 {
                Some(Decision::NoEffect)
            } else {
                None
            };
            if let Some(decision) = decision {
                decide(live.index, decision);
            }
            decision.is_none()
        });
    }

    /// The effects of the instruction at the program counter.
    fn effects(&mut self, memory: &Memory, before: Before) -> Effects {
        let effects = self.decoder.effects(before.pc, || {
            let mut bytes = [0; 4];
            memory.copy(before.pc.into(), &mut bytes);
            bytes
        });
        // In the block of an IT instruction it may not be executed.
        if it_of(before.status) == 0 {
            effects
        } else {
            Effects {
                uses: effects.uses | N | Z | C | V,
                replaces: 0,
            }
        }
    }
}

/// The register that an injection changes; none for the program counter.
fn register(injection: &Injection) -> Option<Registers> {
    let number = injection.address / 4;
    match number {
        0..=14 => Some(1 << number),
        16 => {
            let bit = 8 * (injection.address % 4) as u32 + u32::from(injection.bit);
            Some(match flag(bit) {
                31 => N,
                30 => Z,
                29 => C,
                28 => V,
                _ => Q,
            })
        }
        _ => None,
    }
}
