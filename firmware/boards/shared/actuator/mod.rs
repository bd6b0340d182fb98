//! The program of the actuator board without the peripherals of its chip: the CANopen device with
//! its surroundings, and peripherals that the STM32 chips share.
//!
//! Each chip's program includes this module, and `board`, with one line, and has two modules of its
//! own: `chip` and `peripherals`.

#[macro_use]
mod program;

pub mod background;
pub mod bus_status;
pub mod canopen_task;
pub mod encoder_select;
pub mod parameter_store;
pub mod part_seals;
pub mod pins;
pub mod program_check;
pub mod pwm_timer;
pub mod queues;
pub mod sealed;
pub mod servo_pulse;
pub mod shutdown;
pub mod timebase;
pub mod timing;
pub mod update_result;
pub mod watchdog_supervisor;
pub mod window_watchdog;
pub mod words;
