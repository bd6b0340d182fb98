//! How much of the stack was ever in use: the start-up paints it, what is used loses its paint.

use core::ptr::{addr_of, read_volatile};

unsafe extern "C" {
    /// The lowest word of the stack and the end of its highest one (`memory.x`).
    static _stack_end: u32;
    static _stack_start: u32;
}

/// Bytes that were in use at the worst so far.
pub fn deepest_use() -> u32 {
    let (lowest, end) = (addr_of!(_stack_end), addr_of!(_stack_start));
    let size = end.addr() - lowest.addr();
    let painted = (0..size / 4).take_while(|word| {
        // SAFETY: a word of the stack, which is memory all through; what is there is a number.
        let content = unsafe { read_volatile(lowest.add(*word)) };
        content == cortex_m_rt::STACK_PAINT_VALUE
    });
    (size - 4 * painted.count()) as u32
}
