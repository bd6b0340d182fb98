//! Runs the second emulator in step with the core of the emulated board, and compares both.
//!
//! The board's core runs a stretch of instructions; then the second emulator runs as many, with the
//! recorded reads, and registers are compared. Each handler of an interrupt has a breakpoint at its
//! entry, so that every exception begins between two stretches: it is taken there on the second
//! emulator as well. When a handler ends, all memory that the program can write is compared.

mod comparison;
mod defect;
mod execution;
mod memory_map;

use std::collections::{BTreeSet, VecDeque};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use virtual_board::processor::{CoreBus, Exit, Layered, Memory, Observer, Processor};

pub use self::comparison::Compared;
pub use self::defect::Defect;
use crate::frames::Frames;
use crate::registers::Registers;
use crate::replay::Replay;
use crate::streams::Streams;
use crate::tap::{Event, Tap};
use crate::unicorn::{Unicorn, UnicornError};

/// The RAM.
const RAM: std::ops::Range<u32> = 0x1000_0000..0x4000_0000;

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
    /// The second emulator executed more instructions than were requested.
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

    /// Number of compared reads and writes.
    pub fn accesses(&self) -> u64 {
        self.accesses
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

    /// Ends the comparison, and the run.
    fn end(&mut self, core: &mut dyn Processor, difference: String) {
        self.difference.get_or_insert(difference);
        for handler in &self.handlers {
            core.remove_breakpoint((*handler).into());
        }
        self.stop.store(true, Relaxed);
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
                return (exit, core.retired() - start);
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
