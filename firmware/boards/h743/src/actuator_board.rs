//! Program of the actuator management board: STM32H743, CANopen.
//!
//! The library `firmware` decides everything; this program supplies its samples and carries out its
//! decisions. `docs/hardware.md` shows the wiring and the timing of a control period.
//!
//! `firmware/boards/shared/actuator/program.rs` lists the tasks. Their software interrupts are
//! those of peripherals that the board does not use; so is `FDCAN2_IT0`, as the state of the
//! controller latches until a call asks for it.

#![no_std]
#![no_main]
#![allow(
    unsafe_code,
    reason = "registers and exception handlers: each block states why it is sound"
)]

#[macro_use]
#[path = "../../shared/actuator/mod.rs"]
mod actuator;
#[macro_use]
#[path = "../../shared/board/mod.rs"]
mod board;
mod chip;
mod peripherals;

board_is!("actuator board", "STM32H743");

actuator_program! {
    edge: TIM1_UP,
    instant: TIM_CC,
    encoder_read: SPI1,
    frame_received: FDCAN1_IT0,
    mailbox_free: FDCAN1_IT1,
    bus_status: FDCAN2_IT0,
    software: [UART5, UART7, UART8],
}
