//! Program that runs the checks of `firmware/drivers/src/checks.rs` with the drivers of this chip.

#![no_std]
#![no_main]
#![allow(
    unsafe_code,
    reason = "registers, and memory shared with a DMA controller: each block states why it is sound"
)]

#[allow(
    dead_code,
    unused_macros,
    reason = "the program has the peripherals of the actuator board, and not its CANopen device"
)]
#[macro_use]
#[path = "../../shared/actuator/mod.rs"]
mod actuator;
#[allow(dead_code, reason = "the program needs a part of it")]
#[macro_use]
#[path = "../../shared/board/mod.rs"]
mod board;
#[allow(dead_code, reason = "the program needs a part of it")]
mod chip;
#[path = "../../shared/driver_checks/mod.rs"]
mod driver_checks;
#[allow(dead_code, reason = "the program needs a part of it")]
mod peripherals;

board_is!("driver checks", "STM32F427");

use cortex_m_rt::entry;

use self::{chip::pac::Peripherals, peripherals::wiring};

#[entry]
fn main() -> ! {
    if let Some(device) = Peripherals::take() {
        driver_checks::run(wiring::Peripherals::new(device));
    }
    // The peripherals are taken once, at the start.
    loop {
        cortex_m::asm::wfi();
    }
}
