//! A digest of the program's state: variables, used stack and registers of the core.

use std::hash::{DefaultHasher, Hasher};
use std::ops::Range;

use virtual_board::processor::{Memory, Processor};

use crate::injector::{SP, read};

/// The digest of these ranges of the memory and of the registers. Of the range of the stack it has
/// what lies from the stack pointer on, which is one of these registers: the program reads what
/// lies below it only after it has written it (AAPCS32, 6.2.1.1), and to log the deepest use every
/// 10 s.
/// What a call has left there may remain for seconds.
pub fn digest(core: &dyn Processor, memory: &Memory, ranges: &[Range<u64>]) -> u64 {
    let top = u64::from(read(core, SP));
    let mut hasher = DefaultHasher::new();
    for range in ranges {
        let start = if range.contains(&top) {
            top
        } else {
            range.start
        };
        let mut bytes = vec![0; (range.end - start) as usize];
        memory.copy(start, &mut bytes);
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
