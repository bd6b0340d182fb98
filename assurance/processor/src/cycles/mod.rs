//! An upper bound of the cycles that the executed instructions take on the chip.
//!
//! Every instruction takes its longest time, every store waits for its end, and the flash delays
//! each fetch of a line and each load of an operand, as if it had no caches: the program switches
//! that of operands off while it erases and writes. It is a bound of the executed paths, not of all
//! paths that the program has: the commands of the run are those of the worst cases.

mod cost;
mod operand;
pub mod report;

use std::collections::BTreeMap;

use cost::REFILL;
use program_handlers::Handler;

/// Wait states of the flash at 168 MHz and 2.7 to 3.6 V (RM0090, table 11).
///
/// While the processor executes a line, the next one is prefetched: it arrives this many cycles
/// after the line began, of which each executed instruction is at least one. A branch elsewhere
/// waits for the end of the prefetch, then for its own line; an operand likewise.
const WAIT: u64 = 5;

/// Bytes of a line of the flash, as a shift (RM0090, section 3.5.2).
const LINE_BITS: u32 = 4;

/// The line of an address.
fn line_of(address: u32) -> u32 {
    address >> LINE_BITS
}

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
    /// Cycles.
    pub cycles: u64,
}

impl Call {
    fn larger(self, other: Self) -> Self {
        Self {
            instructions: self.instructions.max(other.instructions),
            cycles: self.cycles.max(other.cycles),
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            instructions: self.instructions + other.instructions,
            cycles: self.cycles + other.cycles,
        }
    }
}

/// A handler that has not ended.
#[derive(Debug, Default, Clone, Copy)]
struct Active {
    exception: u32,
    call: Call,
    uses_float: bool,
}

/// The longest calls, and all of them together.
#[derive(Debug, Default, Clone, Copy)]
pub struct Longest {
    /// The maxima of all calls, each by itself.
    pub most: Call,
    /// The sum of all calls.
    pub sum: Call,
    /// Their number.
    pub calls: u64,
}

/// Tasks that the bounds are made of.
const EDGE: &str = "pwm_edge";
const STEP: &str = "control_step";
const RECEPTION: &str = "frame_received";

/// The model.
#[derive(Debug, Default)]
pub struct Cycles {
    active: Vec<Active>,
    /// Instructions since the last line began.
    since_line: u64,
    /// Where the next instruction is, unless a branch is taken.
    next: u32,
    /// Longest calls by the number of the exception.
    pub calls: BTreeMap<u32, Longest>,
    /// The handlers of the program.
    pub handlers: Vec<Handler>,
    /// The present control period: all handlers that have ended since the last control step began,
    /// without the reception of frames.
    period: Call,
    /// The longest control period.
    pub longest_period: Call,
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
        call.cycles += cost::cycles(first, second) + if is_branch { REFILL } else { 0 };
        let last = self.next.wrapping_sub(1);
        let mut busy = WAIT.saturating_sub(self.since_line);
        let mut fetch = |is_elsewhere: bool| {
            call.cycles += if is_elsewhere { WAIT + busy } else { busy };
            self.since_line = 0;
            busy = WAIT;
        };
        let (begin, end) = (line_of(address), line_of(address + bytes - 1));
        if is_branch || begin != line_of(last) {
            // A line next to the last one may come from the prefetch buffer.
            let is_elsewhere = is_branch && begin != line_of(last) + 1;
            fetch(is_elsewhere);
        }
        if end != begin {
            fetch(false);
        }
        self.since_line += 1;
        if let Some((from, words)) = operand::loaded(address, [first, second], register)
            && FLASH.contains(&from)
        {
            // Each waits for the end of a prefetch, then for its own line.
            call.cycles += u64::from(words) * 2 * WAIT;
        }
        active.call = active.call.plus(call);
        active.uses_float |= cost::is_float(first) && bytes == 4;
        self.next = address + bytes;
    }

    /// An instruction whose condition is not met.
    pub fn skipped(&mut self, bytes: u32) {
        if let Some(active) = self.active.last_mut() {
            active.call.instructions += 1;
            active.call.cycles += 1;
            self.next += bytes;
        }
    }

    /// An access to a peripheral.
    pub fn peripheral(&mut self, address: u32) {
        let cycles = match address >> 16 {
            0x4000 => APB1,
            0x4001 => APB2,
            0xe000 => 0,
            _ => AHB,
        };
        if let Some(active) = self.active.last_mut() {
            active.call.cycles += cycles;
        }
    }

    /// An exception is taken.
    pub fn enter(&mut self, exception: u32) {
        if exception == self.exception(STEP) {
            self.longest_period = self.longest_period.larger(self.period);
            self.period = Call::default();
        }
        let mut active = Active {
            exception,
            ..Active::default()
        };
        active.call.cycles += EXCEPTION;
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
            active.call.cycles += FLOAT_FRAME;
        }
        let longest = self.calls.entry(active.exception).or_default();
        longest.most = longest.most.larger(active.call);
        longest.sum = longest.sum.plus(active.call);
        longest.calls += 1;
        if active.exception != self.exception(RECEPTION) {
            self.period = self.period.plus(active.call);
        }
    }

    /// The exception of a task.
    fn exception(&self, task: &str) -> u32 {
        let handler = self.handlers.iter().find(|handler| handler.task == task);
        handler.map_or(0, |handler| handler.exception)
    }

    /// Forgets the handlers that have not ended.
    pub fn clear(&mut self) {
        self.active.clear();
    }
}
