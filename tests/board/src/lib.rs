//! Support for the tests on the emulated board: the board's program, CANopen frames, a master
//! that sends them, and the same device run natively on the same plant.

pub mod chain;
pub mod comm;
pub mod cuts;
pub mod download;
pub mod flips;
pub mod frames;
pub mod master;
pub mod native;
pub mod program;
pub mod slots;
pub mod workloads;
