//! Stack usage.

use core::ptr::{addr_of, read_volatile};

unsafe extern "C" {
    /// Lowest word of the stack, and end of its highest word (`memory.x`).
    static _stack_end: u32;
    static _stack_start: u32;
}

/// Maximum stack usage since the reset, bytes. The start-up code fills the stack with a pattern,
/// which the program overwrites where it uses the stack.
pub fn maximum_stack_use() -> u32 {
    let (lowest, end) = (addr_of!(_stack_end), addr_of!(_stack_start));
    let size = end.addr() - lowest.addr();
    let unused = (0..size / 4).take_while(|word| {
        // SAFETY: the address is in the stack, which is memory throughout; any content is a number.
        let content = unsafe { read_volatile(lowest.add(*word)) };
        content == cortex_m_rt::STACK_PAINT_VALUE
    });
    (size - 4 * unused.count()) as u32
}
