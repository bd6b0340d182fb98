//! What the programs of both boards share: the processor's start, pins, CAN registers, watchdog, log and safe state.
//!
//! The programs include it as a module instead of linking it from the library `firmware`, because the library forbids
//! unsafe code, which registers and exception handlers need. What only one board has lies in [`crate::actuator`] or
//! `crate::comm`, so that the compiler still finds code that no program uses.

pub mod can_frames;
pub mod can_identifier;
pub mod clocks;
pub mod log;
pub mod memory;
pub mod pins;
pub mod reset_cause;
pub mod safe_state;
pub mod stack;
pub mod watchdog;
