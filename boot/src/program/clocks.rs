//! The clock of a bootloader that waits for an image.
//!
//! A bootloader that only starts a program leaves the clocks as they are after a reset.

use stm32f4xx_hal::pac::{DCB, DWT, RCC};

/// The core's clock, cycles per microsecond.
const CYCLES_PER_US: u32 = 168;

/// The clock of the CAN controller, Hz: a quarter of the core's.
pub const CAN_HZ: u32 = 42_000_000;

/// Runs the core at 168 MHz from the 8 MHz that the Nucleo's debugger supplies, as the program
/// does: CAN needs the accuracy of a crystal. Bus clocks: APB1 a quarter of it, APB2 half.
pub fn start(rcc: &RCC) {
    rcc.cr()
        .modify(|_, w| w.hsebyp().set_bit().hseon().set_bit());
    while rcc.cr().read().hserdy().bit_is_clear() {}
    // 8 MHz / 8 * 336 / 2; the fourth divider is for USB, which is not used.
    // SAFETY: the factors are within the ranges of RM0090, section 6.3.2.
    rcc.pllcfgr().write(|w| unsafe {
        w.pllsrc().hse();
        w.pllm()
            .bits(8)
            .plln()
            .bits(336)
            .pllp()
            .div2()
            .pllq()
            .bits(7)
    });
    rcc.cr().modify(|_, w| w.pllon().set_bit());
    while rcc.cr().read().pllrdy().bit_is_clear() {}
    // Five wait states at 168 MHz and 2.7 to 3.6 V (table 11).
    // SAFETY: one write of one word; the owner of the flash interface does not write this register.
    unsafe {
        (*stm32f4xx_hal::pac::FLASH::ptr())
            .acr()
            .write(|w| w.latency().bits(5))
    };
    rcc.cfgr().modify(|_, w| w.ppre1().div4().ppre2().div2());
    rcc.cfgr().modify(|_, w| w.sw().pll());
    while !rcc.cfgr().read().sws().is_pll() {}
}

/// The longest time between two calls of [`Clock::now_us`] that counts, cycles: 10 ms. While the
/// flash is erased, for seconds, nothing else happens, and no time-out may pass.
const LONGEST: u32 = 10_000 * CYCLES_PER_US;

/// Time since the start without that of erases, from the cycle counter.
pub struct Clock {
    last_cycles: u32,
    now_us: u64,
    rest: u32,
}

impl Clock {
    /// Starts the cycle counter.
    pub fn start(dcb: &mut DCB, dwt: &mut DWT) -> Self {
        dcb.enable_trace();
        dwt.enable_cycle_counter();
        Self {
            last_cycles: DWT::cycle_count(),
            now_us: 0,
            rest: 0,
        }
    }

    /// The time, us.
    pub fn now_us(&mut self) -> u64 {
        let cycles = DWT::cycle_count();
        let elapsed = cycles.wrapping_sub(self.last_cycles).min(LONGEST);
        let elapsed = elapsed.saturating_add(self.rest);
        self.last_cycles = cycles;
        self.now_us += u64::from(elapsed / CYCLES_PER_US);
        self.rest = elapsed % CYCLES_PER_US;
        self.now_us
    }
}
