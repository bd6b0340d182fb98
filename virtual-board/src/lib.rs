//! Emulated boards: an STM32F427, or an STM32H743, that executes the release ELF in lockstep with a
//! motor model.
//!
//! ```text
//!             ┌ chip ── rigless: core, RCC, TIM1, SPI1, ADC1, DMA2, IWDG ..
//! ELF ── run ─┤        └ own: CAN1, FDCAN1 (can), FLASH of the STM32F427 (flash)
//!             ├ board ── encoder on SPI1, comparator at the break input, servo pulses
//!             ├ plant ── bridge, motor, gear train, supply, front ends, encoder
//!             ├ faults ─ planned faults
//!             └ trace ── record of a run, and its hash
//! ```
//!
//! Time is virtual and one instruction takes one cycle of 168 MHz (STM32H743: 336 MHz): the same
//! ELF, options and faults give the same trace on every machine, independently of its load.
//!
//! Not emulated: processor cycles (flash wait states, bus contention), analog settling, the ripple
//! of the current within a PWM period (the plant computes the mean of each slot of its grid), and
//! everything that the models of `rigless` list as omitted.

pub mod board;
pub mod can;
pub mod chip;
pub mod faults;
pub mod flash;
pub use model_core::plant::board as plant;
pub mod processor;
pub mod run;
pub mod serial;
pub mod trace;
