//! The actuator board: its peripherals, and the CANopen device with its surroundings.

pub mod acceptance;
pub mod analog;
pub mod background;
pub mod bridge;
pub mod bus_status;
pub mod can_controller;
pub mod canopen_task;
pub mod dma;
pub mod encoder;
pub mod flash;
pub mod parameter_store;
pub mod pins;
pub mod program_check;
pub mod sealed;
pub mod servo_pulse;
pub mod shutdown;
pub mod timebase;
pub mod timing;
pub mod watchdog_supervisor;
pub mod window_watchdog;
pub mod wiring;
