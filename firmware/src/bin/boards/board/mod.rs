//! Support of the STM32F427 that the programs of both boards share.
//!
//! Each program includes this module with one line. It is not a part of the library `firmware`: the
//! library forbids unsafe code, which registers and exception handlers need. Modules of one board
//! only are in `actuator` and `comm`, so that the compiler still reports code that is never used.

pub mod can_registers;
pub mod diagnostics;
pub mod log;
pub mod safe_state;
pub mod setup;
pub mod watchdog;
