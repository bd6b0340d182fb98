//! The CAN bus: a wire with several stations, and the STM32's bxCAN controller on it.
//!
//! ```text
//! firmware ── registers ── BxCan ── Station ┐
//!                                  Station ├── contest ── Transfer
//! outside port ─────────────────── Station ┘
//! ```
//!
//! Frames are whole, their length in bit times is that of ISO 11898-1 with stuffing. Faults act on
//! whole frames: what a bit error does within one is its outcome, not its waveform.

mod bxcan;
mod counters;
mod fifo;
mod filters;
mod timing;
mod wire;

pub use bxcan::BxCan;
pub use counters::{ErrorCounters, ErrorState};
pub use rigless::chip::can::{Frame, Id};
pub use timing::BitTiming;
pub use wire::{Outcome, Port, Sent, Station, Transfer, Wire, WireFault, contest};
