//! The recording of a board that runs: which injections its next uses of memory and registers
//! decide.

use std::collections::{BTreeMap, VecDeque};

use virtual_board::processor::{CoreBus, Exit, Layered, Memory, Processor};

use crate::accesses::{Accesses, Defect, Layout, Tap};
use crate::defuse::{Decision, Use};
use crate::injection::{Injection, Place};
use crate::liveness::Liveness;

/// Bytes of an instruction, at most and at least.
const WIDE: u64 = 4;
const NARROW: u64 = 2;

/// A recording, and the injections that it decides.
#[derive(Debug)]
pub struct Recording {
    injections: Vec<Injection>,
    /// Number of injections whose millisecond has begun.
    begun: usize,
    /// Instants, ns, and indices of those into memory that are to come.
    coming: VecDeque<(u64, u32)>,
    /// Indices of those into the core whose instructions are counted from the next run on.
    armed: Vec<u32>,
    accesses: Accesses,
    liveness: Liveness,
    /// Number of injections that are undecided at each address at which an instruction may begin.
    breakpoints: BTreeMap<u64, u32>,
}

impl Recording {
    /// A recording that decides these injections, in the order of their instants.
    pub fn of_twin(layout: Layout, injections: Vec<Injection>, defect: Option<Defect>) -> Self {
        let mut recording = Self::new(layout, injections, true);
        recording.accesses.defect = defect;
        recording
    }

    /// A recording of an experiment, which shows whether it stands for these injections: whether
    /// nothing but a check reads their bytes after this instant, ns.
    pub fn of_experiment(layout: Layout, injections: Vec<Injection>, at_ns: u64) -> Self {
        let mut recording = Self::new(layout, injections, false);
        recording.begun = recording.injections.len();
        let indices = 0..recording.injections.len() as u32;
        recording.coming = indices.map(|index| (at_ns, index)).collect();
        recording
    }

    fn new(layout: Layout, injections: Vec<Injection>, do_checks_decide: bool) -> Self {
        Self {
            accesses: Accesses::new(layout, injections.len(), do_checks_decide),
            injections,
            begun: 0,
            coming: VecDeque::new(),
            armed: Vec::new(),
            liveness: Liveness::default(),
            breakpoints: BTreeMap::new(),
        }
    }

    /// A millisecond begins. Returns the instants, ns, at which an experiment would stop to inject
    /// into memory.
    pub fn begin_ms(&mut self, ms: u32, now_ns: u64, register: impl FnMut(u64) -> u32) -> Vec<u64> {
        self.accesses.streams.read(register);
        let mut instants = Vec::new();
        while let Some(injection) = self.injections.get(self.begun)
            && injection.at_ms <= ms
        {
            let index = self.begun as u32;
            match injection.place {
                Place::Ram | Place::Code => {
                    instants.push((now_ns + injection.phase_ns(), index));
                }
                Place::Registers | Place::Instruction | Place::Period => self.armed.push(index),
            }
            self.begun += 1;
        }
        instants.sort_unstable();
        self.coming.extend(&instants);
        let mut instants: Vec<u64> = instants.into_iter().map(|(at_ns, _)| at_ns).collect();
        instants.dedup();
        instants
    }

    /// The decisions, in the order of the injections.
    pub fn decisions(&self) -> Vec<Decision> {
        let accesses = &self.accesses;
        let may_transfer = |injection: &Injection| {
            injection.place == Place::Ram
                && accesses.defect != Some(Defect::NoTransfers)
                && accesses.streams.may_access(injection.address)
        };
        let decision = |(index, injection): (usize, &Injection)| {
            if may_transfer(injection) {
                Decision::Simulate
            } else {
                accesses.decision(index as u32)
            }
        };
        self.injections.iter().enumerate().map(decision).collect()
    }

    /// Indices of the injections for which the experiment does not stand.
    pub fn exceptions(&self) -> Vec<u32> {
        let is_exception = |(index, decision): (usize, Decision)| {
            // A bit of the copy would show what was copied.
            let is_copied =
                self.injections[index].place == Place::Ram && self.accesses.is_copy_read;
            (is_copied || decision == Decision::Simulate).then_some(index as u32)
        };
        let decisions = self.decisions().into_iter().enumerate();
        decisions.filter_map(is_exception).collect()
    }

    /// Runs the core as [`virtual_board::processor::Observer::run`] does, and records.
    pub fn run(
        &mut self,
        core: &mut dyn Processor,
        memory: &Memory,
        budget: u32,
        bus: &mut dyn CoreBus,
    ) -> (Exit, u64) {
        let start = core.retired();
        let now_ns = bus.time(start).0;
        self.inject(core, now_ns);
        let mut end = start + u64::from(budget);
        loop {
            let now = core.retired();
            self.accesses.route(core);
            self.liveness.inject(now);
            let observed = self.liveness.before(&*core, self.accesses.frame_accesses);
            let until = self.liveness.unobserved_until(now).max(now + 1).min(end);
            if until <= now {
                return (Exit::Budget, now - start);
            }
            let mut tap = Layered(Tap::new((bus, memory), &mut self.accesses, until, end));
            let (exit, _) = core.run((until - now) as u32, &mut tap);
            let must_return;
            (must_return, end) = tap.0.finish();
            if let Some(before) = observed {
                let accesses = &mut self.accesses;
                let frames = accesses.frame_accesses;
                let decisions = &mut accesses.decisions;
                let decide = |index: u32, decision| decisions[index as usize] = decision;
                self.liveness
                    .observe(&*core, memory, before, frames, decide);
            }
            let may_continue = match exit {
                Exit::Budget => true,
                Exit::Returned => !must_return && core.retired() >= until,
                Exit::Breakpoint => self.execute(core),
                _ => false,
            };
            if !may_continue {
                return (exit, core.retired() - start);
            }
        }
    }

    /// Makes the injections that are due.
    fn inject(&mut self, core: &mut dyn Processor, now_ns: u64) {
        let retired = core.retired();
        for index in self.armed.drain(..) {
            let injection = &self.injections[index as usize];
            if injection.place == Place::Registers {
                let at = retired + u64::from(injection.instructions);
                self.liveness.add(index, injection, at);
            }
        }
        while let Some(&(at_ns, index)) = self.coming.front()
            && at_ns <= now_ns
        {
            self.coming.pop_front();
            let Injection { address, place, .. } = self.injections[index as usize];
            self.accesses.inject(core, index, address);
            if place == Place::Code {
                for at in instructions_with(address) {
                    let injections = self.breakpoints.entry(at).or_insert(0);
                    *injections += 1;
                    if *injections == 1 {
                        core.add_breakpoint(at);
                    }
                }
            }
        }
    }

    /// The core is about to execute an instruction with a breakpoint. Returns whether it is one of
    /// this recording.
    fn execute(&mut self, core: &mut dyn Processor) -> bool {
        let at = core.pc();
        let is_own = self.breakpoints.remove(&at).is_some();
        if is_own {
            core.remove_breakpoint(at);
            let number = core.retired() + 1;
            self.accesses.decide(at, WIDE as usize, Use::Read, number);
        }
        is_own
    }
}

/// The addresses at which an instruction may begin that contains this byte.
fn instructions_with(address: u64) -> [u64; 2] {
    let half = address & !(NARROW - 1);
    [half - NARROW, half]
}
