//! Program for the first start of an actuator board: it exercises the parts of the board one by one
//! and reports what each measures. `docs/hardware.md` describes how to use it.
//!
//! It has no interrupts: a timer wakes the processor, and the program polls.

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
#[path = "../../shared/bring_up/mod.rs"]
mod bring_up;
#[allow(dead_code, reason = "the program needs a part of it")]
mod chip;
#[allow(dead_code, reason = "the program needs a part of it")]
mod peripherals;

board_is!("bring-up", "STM32F427");

use cortex_m_rt::entry;

use self::{
    chip::pac::{Interrupt, Peripherals},
    peripherals::{backup, wiring},
};

#[entry]
fn main() -> ! {
    // The set-up of the peripherals clears the register.
    let mark = backup::read();
    if let Some(device) = Peripherals::take() {
        let peripherals = wiring::Peripherals::new(device);
        bring_up::run(
            peripherals,
            mark,
            [Interrupt::TIM1_UP_TIM10, Interrupt::TIM1_CC],
        );
    }
    // The peripherals are taken once, at the start.
    loop {
        cortex_m::asm::wfi();
    }
}
