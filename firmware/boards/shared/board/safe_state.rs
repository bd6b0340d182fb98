//! The safe state after a fault of the program: all switches open until the watchdog resets the
//! processor.

use cortex_m_rt::{ExceptionFrame, exception};

use crate::chip::pac::TIM1;

/// Opens all four switches at once, from any context.
fn open_all_switches() {
    // SAFETY: one write of one word; the owner of the timer does not run any more.
    let timer = unsafe { &*TIM1::ptr() };
    timer.bdtr().modify(|_, w| w.moe().clear_bit());
}

// SAFETY: the handler accesses the timer only and never returns.
#[exception]
unsafe fn HardFault(_: &ExceptionFrame) -> ! {
    open_all_switches();
    loop {
        cortex_m::asm::nop();
    }
}

// An enabled interrupt without a handler is an error of the program.
// SAFETY: as above.
#[exception]
unsafe fn DefaultHandler(_: i16) -> ! {
    open_all_switches();
    loop {
        cortex_m::asm::nop();
    }
}

/// The program has no path to a panic: if one remains, this function is linked, and linking fails
/// because the function that it calls is not defined.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        safe fn a_path_to_a_panic_remains() -> !;
    }
    open_all_switches();
    a_path_to_a_panic_remains()
}
