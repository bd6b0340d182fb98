//! A digest of the program's state: variables, stack and registers of the core.

use std::hash::{DefaultHasher, Hasher};
use std::ops::Range;

use virtual_board::processor::{Memory, Processor};

/// The digest of these ranges of the memory and of the registers.
pub fn digest(core: &dyn Processor, memory: &Memory, ranges: &[Range<u64>]) -> u64 {
    let mut hasher = DefaultHasher::new();
    for range in ranges {
        let mut bytes = vec![0; (range.end - range.start) as usize];
        memory.copy(range.start, &mut bytes);
        hasher.write(&bytes);
    }
    for number in 0.. {
        let Some(register) = core.gdb_register(number) else {
            break;
        };
        hasher.write(&register);
    }
    hasher.finish()
}
