//! The STM32F427, as the programs of both boards use it.

pub mod can_registers;

pub use stm32f4xx_hal::pac;

use firmware::supervisor::ResetCause;
use stm32f4xx_hal::{
    prelude::*,
    rcc::{Config, Rcc},
    time::Hertz,
};

/// Address of port A's registers (RM0090, section 2.3).
pub const PORTS: u32 = 0x4002_0000;

/// Speed of a pin with edges below 100 ns (section 8.4.3).
pub const HIGH_SPEED: u32 = 0b10;

/// Starts the core at this clock, from the 8 MHz that the Nucleo's debugger supplies. APB2 runs at
/// half the core clock, APB1 at a quarter; timers run at twice the clock of their bus.
pub fn start_clocks(rcc: pac::RCC, core: Hertz) -> Rcc {
    let clocks = Config::hse(8.MHz())
        .bypass_hse_oscillator()
        .sysclk(core)
        .pclk1(core / 4)
        .pclk2(core / 2);
    rcc.freeze(clocks)
}

/// Reads the reset cause and clears its flags, so that they show the next reset alone.
pub fn take_reset_cause(rcc: &pac::RCC) -> ResetCause {
    let cause = ResetCause::of_csr(rcc.csr().read().bits());
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    cause
}
