//! The communication board: an slcan adapter between a serial line and a CAN bus.

pub mod can_controller;
pub mod pins;
pub mod serial;
pub mod slcan_adapter;
pub mod timers;
pub mod wiring;
