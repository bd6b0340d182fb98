//! An upper bound of the cycles that the executed instructions take on the chip.
//!
//! Every instruction takes its longest time, every store waits for its end, and the flash delays
//! each fetch of a line that is not certainly in the instruction cache. It is a bound of the
//! executed paths, not of all paths that the program has: the commands of the run are those of the
//! worst cases.

mod cost;
mod lines;
mod operand;
pub mod report;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use cost::REFILL;
use lines::{Lines, line_of};

/// Wait states of the flash at 168 MHz and 2.7 to 3.6 V (RM0090, table 11).
///
/// While the processor executes a line, the next one is prefetched: it arrives this many cycles
/// after the line began, of which each executed instruction is at least one. A branch elsewhere
/// waits for the end of the prefetch, then for its own line; an operand likewise.
const WAIT: u64 = 5;

/// Lines in the caches of instructions and of operands (RM0090, section 3.5.2).
const INSTRUCTION_LINES: usize = 64;
const OPERAND_LINES: usize = 8;

/// The program's bank of the flash.
const FLASH: std::ops::Range<u32> = 0x0800_0000..0x0810_0000;

/// Cycles of an access to a peripheral beyond those of a load: on AHB; on APB2 at half the core's
/// clock; on APB1 at a quarter. A transfer on APB takes two of its cycles, begins with the next
/// one, and the bridge passes address and data with a cycle each (AMBA 3 APB, IHI 0024, section 3).
const AHB: u64 = 2;
const APB2: u64 = 3 * 2 + 2;
const APB1: u64 = 3 * 4 + 2;

/// Cycles to take an exception and to return from it (100166_0001, section 3.9), the vector from
/// the flash, and the delay of the accesses of the two DMA streams that run, 16 in a control
/// period.
const EXCEPTION: u64 = 12 + 10 + 2 * WAIT + 2 * 16;

/// Cycles to store and restore the floating-point registers of a frame: 17 words and a cycle.
const FLOAT_FRAME: u64 = 2 * 18;

/// What a call of a handler takes at most, without what preempts it.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct Call {
    /// Executed instructions.
    pub instructions: u64,
    /// Cycles, with lines that are certainly in the cache.
    pub cycles: u64,
    /// Cycles, if no line is ever in the cache.
    pub uncached: u64,
}

impl Call {
    fn add(&mut self, cycles: u64) {
        self.cycles += cycles;
        self.uncached += cycles;
    }

    fn larger(self, other: Self) -> Self {
        Self {
            instructions: self.instructions.max(other.instructions),
            cycles: self.cycles.max(other.cycles),
            uncached: self.uncached.max(other.uncached),
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            instructions: self.instructions + other.instructions,
            cycles: self.cycles + other.cycles,
            uncached: self.uncached + other.uncached,
        }
    }
}

/// A handler that has not ended.
#[derive(Debug, Default, Clone, Copy)]
struct Active {
    exception: u32,
    call: Call,
    uses_float: bool,
    /// Cycles of this call up to the last reading of the cycle counter, if any.
    read: Option<u64>,
    /// The parts of a turn of the node.
    turn: Turn,
    /// The node has begun with process data: it takes no reset in this turn.
    has_process_data: bool,
}

/// The longest calls, and all of them together.
#[derive(Debug, Default, Clone, Copy)]
pub struct Longest {
    /// The maxima of all calls, each by itself.
    pub most: Call,
    /// The sum of all calls.
    pub sum: Call,
}

/// The exceptions that make up a tick, and the one that begins it.
const TICK: [u32; 3] = [72, 41, 43];

/// The exception in which the node runs, and the cycle counter that limits how many frames it
/// takes.
const NODE: u32 = 98;
const CYCLE_COUNTER: u32 = 0xe000_1004;

/// The parts of a turn of the node, cycles at most.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct Turn {
    /// Before the first frame.
    pub begin: u64,
    /// A frame, or the process data with which it begins.
    pub frame: u64,
    /// After the last frame.
    pub end: u64,
}

impl Turn {
    fn larger(self, other: Self) -> Self {
        Self {
            begin: self.begin.max(other.begin),
            frame: self.frame.max(other.frame),
            end: self.end.max(other.end),
        }
    }
}

/// The model.
#[derive(Debug)]
pub struct Cycles {
    lines: Lines,
    operands: Lines,
    active: Vec<Active>,
    /// Instructions since the last line began.
    since_line: u64,
    /// Where the next instruction is, unless a branch is taken.
    next: u32,
    /// Longest calls by the number of the exception.
    pub calls: BTreeMap<u32, Longest>,
    /// The longest parts of the turns of the node: of ordinary ones, and of those with the requests
    /// after which much is computed anew.
    pub turns: [Turn; 2],
    /// Such requests are sent.
    pub is_reset: Arc<AtomicBool>,
    /// Where the program processes the process data with which a turn may begin.
    pub process_data: u32,
    /// The present tick.
    tick: Call,
    /// The longest tick.
    pub longest_tick: Call,
}

impl Default for Cycles {
    fn default() -> Self {
        Self {
            lines: Lines::new(INSTRUCTION_LINES),
            operands: Lines::new(OPERAND_LINES),
            active: Vec::new(),
            since_line: 0,
            next: 0,
            calls: BTreeMap::new(),
            turns: Default::default(),
            is_reset: Arc::default(),
            process_data: 0,
            tick: Call::default(),
            longest_tick: Call::default(),
        }
    }
}

impl Cycles {
    /// Executes an instruction of one or two halfwords, with these values of R0 to R15.
    pub fn instruction(
        &mut self,
        address: u32,
        [first, second]: [u16; 2],
        register: &dyn Fn(u8) -> u32,
    ) {
        let Some(active) = self.active.last_mut() else {
            return;
        };
        let bytes = crate::replay::size(first);
        let is_branch = address != self.next;
        let mut call = Call {
            instructions: 1,
            ..Call::default()
        };
        call.add(cost::cycles(first, second) + if is_branch { REFILL } else { 0 });
        let last = self.next.wrapping_sub(1);
        let mut busy = WAIT.saturating_sub(self.since_line);
        let mut fetch = |line: u32, is_elsewhere: bool| {
            let wait = if is_elsewhere { WAIT + busy } else { busy };
            call.uncached += wait;
            if !self.lines.fetch(line, is_elsewhere) {
                call.cycles += wait;
            }
            self.since_line = 0;
            busy = WAIT;
        };
        let (begin, end) = (line_of(address), line_of(address + bytes - 1));
        if is_branch || begin != line_of(last) {
            // A line next to the last one may come from the prefetch buffer.
            let is_elsewhere = is_branch && begin != line_of(last) + 1;
            fetch(begin, is_elsewhere);
        }
        if end != begin {
            fetch(end, false);
        }
        self.since_line += 1;
        if let Some((from, words)) = operand::loaded(address, [first, second], register)
            && FLASH.contains(&from)
        {
            for line in line_of(from)..=line_of(from + 4 * words - 1) {
                call.uncached += 2 * WAIT;
                if !self.operands.fetch(line, true) {
                    call.cycles += 2 * WAIT;
                }
            }
        }
        active.call = active.call.plus(call);
        active.has_process_data |= address == self.process_data;
        active.uses_float |= cost::is_float(first) && bytes == 4;
        self.next = address + bytes;
    }

    /// An instruction whose condition is not met.
    pub fn skipped(&mut self, bytes: u32) {
        if let Some(active) = self.active.last_mut() {
            active.call.instructions += 1;
            active.call.add(1);
            self.next += bytes;
        }
    }

    /// An access to a peripheral.
    pub fn peripheral(&mut self, address: u32) {
        if address == CYCLE_COUNTER {
            self.end_part();
        }
        let cycles = match address >> 16 {
            0x4000 => APB1,
            0x4001 => APB2,
            0xe000 => 0,
            _ => AHB,
        };
        if let Some(active) = self.active.last_mut() {
            active.call.add(cycles);
        }
    }

    /// The node reads the cycle counter: before its first frame, and after each one.
    fn end_part(&mut self) {
        if let Some(active) = self
            .active
            .last_mut()
            .filter(|active| active.exception == NODE)
        {
            let now = active.call.cycles;
            match active.read.replace(now) {
                None => active.turn.begin = now,
                Some(before) => active.turn.frame = active.turn.frame.max(now - before),
            }
        }
    }

    /// An exception is taken.
    pub fn enter(&mut self, exception: u32) {
        if exception == TICK[0] {
            self.longest_tick = self.longest_tick.larger(self.tick);
            self.tick = Call::default();
        }
        let mut active = Active {
            exception,
            ..Active::default()
        };
        active.call.add(EXCEPTION);
        self.active.push(active);
        self.next = 0;
    }

    /// The program returns from an exception.
    pub fn leave(&mut self) {
        self.next = 0;
        let Some(mut active) = self.active.pop() else {
            return;
        };
        if active.uses_float {
            active.call.add(FLOAT_FRAME);
        }
        if active.exception == NODE {
            active.turn.end = active.call.cycles - active.read.unwrap_or(0);
            let is_reset = self.is_reset.load(Relaxed) && !active.has_process_data;
            let longest = &mut self.turns[usize::from(is_reset)];
            *longest = longest.larger(active.turn);
        }
        let longest = self.calls.entry(active.exception).or_default();
        longest.most = longest.most.larger(active.call);
        longest.sum = longest.sum.plus(active.call);
        if TICK.contains(&active.exception) {
            self.tick = self.tick.plus(active.call);
        }
    }

    /// Forgets the handlers that have not ended.
    pub fn clear(&mut self) {
        self.active.clear();
    }
}
