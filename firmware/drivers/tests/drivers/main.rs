//! The drivers with mocks in place of the hardware.

mod bridge;
mod controller;
mod mocks;
