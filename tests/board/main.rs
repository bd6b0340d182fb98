//! The release ELF on the emulated board.

mod adapter;
mod adapter_load;
mod bit_exact;
mod canopen;
mod chain;
mod faults;
mod instructions;
mod joined;
mod log;
mod orders;
mod power_loss;
mod resets;
mod same_trace;
mod stack;
mod wiring;
