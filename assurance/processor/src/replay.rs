//! The host of the second emulator: answers its accesses with the recorded ones, and compares what
//! it writes.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use crate::tap::Event;
use crate::unicorn::{Host, Memory};

/// The bit-band alias of the peripherals, and what it stands for (PM0214, section 2.2.5).
const ALIAS: std::ops::Range<u32> = 0x4200_0000..0x4400_0000;
const PERIPHERALS: u32 = 0x4000_0000;

/// The registers of the core itself, which no bus carries (PM0214, section 4.1).
const SYSTEM_CONTROL: std::ops::Range<u32> = 0xe000_e000..0xe000_f000;

/// The host.
#[derive(Debug, Default)]
pub struct Replay {
    /// Recorded accesses that have not been made yet.
    pub log: VecDeque<Event>,
    /// Instructions of this run so far, and when it ends.
    pub executed: u64,
    /// Instructions after which the run ends.
    pub target: u64,
    /// The run ended before an IT instruction whose block ends after the target.
    pub before_block: bool,
    /// The emulator was requested to stop.
    is_stopped: bool,
    /// The emulator executed more instructions than were requested.
    pub overran: bool,
    /// The run ended with a return from an exception.
    pub returned: bool,
    /// What differs first.
    pub difference: Option<String>,
    /// The emulator's memory.
    pub memory: Arc<Memory>,
    /// Number of compared reads and writes.
    pub accesses: u64,
    /// Registers of the system control space that were written; the others are 0, as after a reset.
    system: BTreeMap<u32, u32>,
    /// The instruction that executes.
    instruction: u32,
    /// The instructions of the present block of an IT instruction that have not been counted.
    block: VecDeque<u32>,
}

/// Number of instructions in the block of this IT instruction; `None` for any other.
pub fn block_length(half: u16) -> Option<u32> {
    let mask = half & 0xf;
    (half & 0xff00 == 0xbf00 && mask != 0).then(|| 4 - mask.trailing_zeros())
}

/// Bytes of the instruction that begins with this halfword (DDI 0403E, A5.1).
pub fn size(half: u16) -> u32 {
    if half >> 11 >= 0b11101 { 4 } else { 2 }
}

impl Replay {
    /// Records what differs, unless something did before.
    pub fn differs(&mut self, what: impl FnOnce() -> String) {
        if self.difference.is_none() {
            self.difference = Some(what());
        }
    }

    /// Prepares a run of this number of instructions.
    pub fn begin(&mut self, instructions: u64) {
        self.executed = 0;
        self.target = instructions;
        self.before_block = false;
        self.returned = false;
        self.is_stopped = false;
        self.overran = false;
    }

    /// Takes the next recorded access, which must be this one; returns its value.
    fn next(&mut self, is_write: bool, address: u32, bytes: u32) -> Option<u32> {
        self.accesses += 1;
        let Some(event) = self.log.pop_front() else {
            let instruction = self.instruction;
            self.differs(|| {
                format!(
                    "an access to {address:08x} by {instruction:08x} that the board does not make"
                )
            });
            return None;
        };
        let found = (is_write, address, bytes, self.instruction);
        let expected = (
            event.is_write,
            event.address,
            event.bytes,
            event.instruction,
        );
        if found != expected {
            self.differs(|| {
                format!("access (write, address, bytes, instruction) {found:x?}, on the board {expected:x?}")
            });
            return None;
        }
        Some(event.value)
    }

    fn compare_write(&mut self, address: u32, bytes: u32, value: u32) {
        let mask = u32::MAX >> (32 - 8 * bytes);
        let instruction = self.instruction;
        if let Some(expected) = self.next(true, address, bytes)
            && (expected ^ value) & mask != 0
        {
            self.differs(|| {
                format!("{instruction:08x} writes {value:08x} to {address:08x}, on the board {expected:08x}")
            });
        }
    }

    /// Begins a block of this number of instructions.
    fn begin_block(&mut self, first: u32, length: u32) {
        let mut address = first;
        for _ in 0..length {
            self.block.push_back(address);
            let half = self.memory.half(address).unwrap_or(0);
            address += size(half);
        }
    }

    /// Counts the instructions of the block before this address, whose condition is not met: the
    /// emulator jumps over them.
    fn count_skipped(&mut self, address: u32) {
        while let Some(next) = self.block.pop_front() {
            if next == address {
                return;
            }
            self.executed += 1;
        }
    }

    /// The word and the bit in it that an address of the alias stands for.
    fn aliased(address: u32) -> (u32, u32) {
        let offset = address - ALIAS.start;
        let byte = PERIPHERALS + offset / 32;
        (byte & !3, 8 * (byte & 3) + offset / 4 % 8)
    }
}

impl Host for Replay {
    fn instruction(&mut self, address: u32) -> bool {
        if !self.block.is_empty() {
            self.count_skipped(address);
        }
        if self.is_stopped {
            self.overran = true;
            return false;
        }
        if self.executed >= self.target || self.difference.is_some() {
            self.is_stopped = true;
            return false;
        }
        let first = self.memory.half(address).unwrap_or(0);
        if let Some(length) = block_length(first) {
            if self.executed + 1 + u64::from(length) >= self.target {
                // The emulator stops neither within the block nor immediately after it.
                self.before_block = true;
                self.is_stopped = true;
                return false;
            }
            self.begin_block(address + 2, length);
        }
        self.executed += 1;
        self.instruction = address;
        true
    }

    fn read(&mut self, address: u32, bytes: u32) -> u32 {
        if SYSTEM_CONTROL.contains(&address) {
            return self.system.get(&address).copied().unwrap_or(0);
        }
        if ALIAS.contains(&address) {
            let (word, bit) = Self::aliased(address);
            return self.next(false, word, bytes).unwrap_or(0) >> bit & 1;
        }
        self.next(false, address, bytes).unwrap_or(0)
    }

    fn write(&mut self, address: u32, bytes: u32, value: u32) {
        if SYSTEM_CONTROL.contains(&address) {
            self.system.insert(address, value);
        } else if ALIAS.contains(&address) {
            let (word, bit) = Self::aliased(address);
            let before = self.next(false, word, bytes).unwrap_or(0);
            let after = before & !(1 << bit) | (value & 1) << bit;
            self.compare_write(word, bytes, after);
        } else {
            self.compare_write(address, bytes, value);
        }
    }

    fn access(&mut self, address: u32, bytes: u32, write: Option<u32>) {
        if let Some(value) = write {
            self.compare_write(address, bytes, value);
            return;
        }
        if let Some(expected) = self.next(false, address, bytes) {
            let expected = &expected.to_le_bytes()[..bytes as usize];
            self.memory.write(address, expected);
        }
    }

    fn exception_return(&mut self) {
        self.returned = true;
    }
}
