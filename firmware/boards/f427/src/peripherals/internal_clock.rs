//! The clock after a failure of the external one, with which the program can still brake.

use stm32f4xx_hal::{prelude::*, rcc::Rcc};

use crate::chip::pac::{FLASH, RCC};

/// Whether the 8 MHz arrive within 10 ms.
pub fn is_external_there(rcc: &RCC) -> bool {
    // Of some ten cycles of 16 MHz each.
    const READINGS: u32 = 20_000;
    rcc.cr().modify(|_, w| w.hsebyp().set_bit());
    rcc.cr().modify(|_, w| w.hseon().set_bit());
    (0..READINGS).any(|_| rcc.cr().read().hserdy().bit())
}

/// Starts the core at 168 MHz from the internal oscillator, -8 to 4.5 % (DS9405), with the buses as
/// [`chip::start_clocks`](crate::chip::start_clocks) sets them.
pub fn start(rcc: RCC, flash: &FLASH) -> Rcc {
    rcc.cr().modify(|_, w| w.hseon().clear_bit());
    // 16 MHz / 8 x 168 / 2.
    // SAFETY: the values are in the ranges of RM0090, section 6.3.2.
    rcc.pllcfgr().modify(|_, w| unsafe {
        w.pllsrc()
            .hsi()
            .pllm()
            .bits(8)
            .plln()
            .bits(168)
            .pllp()
            .div2()
    });
    rcc.cr().modify(|_, w| w.pllon().set_bit());
    while rcc.cr().read().pllrdy().bit_is_clear() {}
    // Five wait states at 168 MHz and 3.3 V (table 11).
    flash.acr().modify(|_, w| {
        w.latency().ws5();
        w.prften().set_bit().icen().set_bit().dcen().set_bit()
    });
    rcc.cfgr()
        .modify(|_, w| w.hpre().div1().ppre1().div4().ppre2().div2());
    rcc.cfgr().modify(|_, w| w.sw().pll());
    while !rcc.cfgr().read().sws().is_pll() {}
    rcc.constrain()
}
