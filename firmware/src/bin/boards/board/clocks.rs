//! The clock tree: every board has the Nucleo's 8 MHz, which come from its debugger.

use stm32f4xx_hal::{
    pac,
    prelude::*,
    rcc::{Config, Rcc},
    time::Hertz,
};

/// Starts the core at this clock, APB2 at half of it, APB1 at a quarter; timers run at twice their bus.
pub fn start(rcc: pac::RCC, core: Hertz) -> Rcc {
    let clocks = Config::hse(8.MHz())
        .bypass_hse_oscillator()
        .sysclk(core)
        .pclk1(core / 4)
        .pclk2(core / 2);
    rcc.freeze(clocks)
}
