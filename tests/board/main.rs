//! The release ELF on the emulated board.

mod adapter;
mod adapter_load;
mod bit_exact;
mod bring_up;
mod bus;
mod chain;
mod drivers;
mod faults;
mod gaps;
mod instructions;
mod joined;
mod log;
mod motion;
mod power_loss;
mod repeated_step;
mod requests;
mod resets;
mod safe_motion;
mod same_trace;
mod second_chip;
mod service_password;
mod staging_cuts;
mod update;
mod whole_update;
mod wiring;
mod worst_case;
