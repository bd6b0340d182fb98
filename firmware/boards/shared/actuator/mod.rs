//! The program of the actuator board without the peripherals of its chip: the tasks of loop and
//! communication, and peripherals that the STM32 chips share.
//!
//! Each chip's program includes this module, and `board`, with one line, and has two modules of its
//! own: `chip` and `peripherals`.

#[macro_use]
mod program;

pub mod background;
pub mod bus_status;
pub mod comm_task;
pub mod encoder_select;
pub mod line_timer;
pub mod loop_memory;
pub mod loop_task;
pub mod mailboxes;
pub mod parameter_store;
pub mod pins;
pub mod program_check;
pub mod pwm_timer;
pub mod queues;
pub mod sampling;
pub mod servo_bus_task;
pub mod servo_pulse;
pub mod shutdown;
pub mod timebase;
pub mod timing;
pub mod update_result;
pub mod watchdog_supervisor;
pub mod window_watchdog;
