//! Reset cause and stack usage.

use core::ptr::{addr_of, read_volatile};

use firmware::supervisor::ResetCause;
use stm32f4xx_hal::pac::RCC;

/// Reads the reset cause and clears its flags, so that they show the next reset alone.
pub fn take_reset_cause(rcc: &RCC) -> ResetCause {
    let cause = ResetCause::of_csr(rcc.csr().read().bits());
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    cause
}

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
