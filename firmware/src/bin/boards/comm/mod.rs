//! The communication board: what lies between its serial line and its bus.

pub mod adapter;
pub mod can_bus;
pub mod serial;
pub mod stopwatch;
pub mod wiring;
