//! The CAN bus: a wire with several stations, and the controllers bxCAN and FDCAN of the
//! STM32 on it.
//!
//! ```text
//! firmware ── registers ── BxCan ── Station ┐
//!                          FdCan ── Station ┤
//!                                  Station ├── arbitration ── Transfer
//! outside port ─────────────────── Station ┘
//! ```
//!
//! The model resolves whole frames, with the length in bit times of ISO 11898-1 including stuff
//! bits. Faults act on whole frames: a bit error determines the outcome of its frame.

mod bxcan;
mod counters;
mod fdcan;
mod fifo;
mod filters;
mod timing;
mod wire;

pub use bxcan::BxCan;
pub use counters::{ErrorCounters, ErrorState};
pub use fdcan::{FdCan, MESSAGE_RAM_BYTES, MessageRam};
pub use rigless::chip::can::{Frame, Id};
pub use timing::BitTiming;
pub use wire::{Outcome, Port, Sent, Station, Transfer, Wire, WireFault, arbitrate};
