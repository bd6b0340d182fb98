//! The hardware of the actuator board, and the CANopen device on it.

pub mod actuator_pins;
pub mod analog;
pub mod boot_stack;
pub mod bridge;
pub mod bus_state;
pub mod can;
pub mod can_filters;
pub mod canopen;
pub mod dma;
pub mod encoder;
pub mod flash;
pub mod heard;
pub mod keeper;
pub mod report;
pub mod sampling;
pub mod serial_number;
pub mod servo_pulse;
pub mod slot;
pub mod ticks;
pub mod vigil;
pub mod wiring;
