//! The drivers with mocks in place of the hardware.

mod checks;
mod controller;
mod mocks;
