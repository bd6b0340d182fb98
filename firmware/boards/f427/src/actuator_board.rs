//! Program of the actuator management board: STM32F427, CANopen.
//!
//! The library `firmware` decides everything; this program supplies its samples and carries out its
//! decisions. `docs/hardware.md` shows the wiring and the timing of a control period.
//!
//! `firmware/boards/shared/actuator/program.rs` lists the tasks. Their software interrupts are
//! those of peripherals that the board does not use.

#![no_std]
#![no_main]
#![allow(
    unsafe_code,
    reason = "registers, and memory shared with a DMA controller: each block states why it is sound"
)]

#[macro_use]
#[path = "../../shared/actuator/mod.rs"]
mod actuator;
#[macro_use]
#[path = "../../shared/board/mod.rs"]
mod board;
mod chip;
mod peripherals;

board_is!("actuator board", "STM32F427");

actuator_program! {
    edge: TIM1_UP_TIM10,
    instant: TIM1_CC,
    encoder_read: DMA2_STREAM0,
    frame_received: CAN1_RX0,
    mailbox_free: CAN1_TX,
    bus_status: CAN1_SCE,
    software: [UART5, UART7, UART8],
}
